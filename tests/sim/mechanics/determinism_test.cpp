#include <gtest/gtest.h>

#include "tests/support/program.h"

namespace kirireel {
namespace {

std::string hashWith(const std::string& environment) {
  return test::outputOf(environment + " '" + MOTION_HASH_PROGRAM + "'");
}

TEST(Determinism, SameBytesOnEveryRun) {
  const std::string hash = hashWith("");
  EXPECT_EQ(hash.size(), 17U);
  EXPECT_EQ(hashWith(""), hash);
}

TEST(Determinism, SameBytesWithAnyThreadCount) {
  const std::string hash = hashWith("OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1");
  EXPECT_EQ(hashWith("OMP_NUM_THREADS=2 OPENBLAS_NUM_THREADS=2"), hash);
  EXPECT_EQ(hashWith("OMP_NUM_THREADS=7 OPENBLAS_NUM_THREADS=7"), hash);
}

TEST(Determinism, SameBytesForAnyContentOfFreshMemory) {
  EXPECT_EQ(hashWith("MALLOC_PERTURB_=0"), hashWith("MALLOC_PERTURB_=171"));
}

}  // namespace
}  // namespace kirireel
