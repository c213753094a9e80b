#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/gl_context.h"
#include "sim/base/error.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using ::testing::EndsWith;
using ::testing::StartsWith;

constexpr const char* kVertexShader = R"(#version 330 core
void main() { gl_Position = vec4(0.0); }
)";
constexpr const char* kFragmentShader = R"(#version 330 core
out vec4 colour;
void main() { colour = vec4(1.0); }
)";

TEST(ContextDeathTest, ReportsWhatToDoWithoutOpenGl) {
  // In its own process, because the driver remembers the first answer.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto makeContext = [] {
    // The driver then supports less than the required version.
    ::setenv("MESA_GL_VERSION_OVERRIDE", "2.1", 1);
    std::fputs(test::refusalOf<OutputError>([] { const picture::Context context; }).c_str(),
               stderr);
    std::exit(0);
  };
  EXPECT_EXIT(
      makeContext(), ::testing::ExitedWithCode(0),
      "error: cannot make an OpenGL 3.3 context off screen with osmesa; check that the package "
      "libosmesa6 is installed and that no MESA_ or GALLIUM_ variable is set in the "
      "environment");
}

TEST(GraphicsLibrary, IsOneThatTheProgramWasBuiltWith) {
  int missing = 0;
  // The default comes last and stays chosen.
  for (const auto& [library, message] :
       {std::pair{picture::GraphicsLibrary::Egl,
                  "built without EGL; choose --gl osmesa, or install"},
        std::pair{picture::GraphicsLibrary::Osmesa,
                  "built without OSMesa; choose --gl egl, or install"}}) {
    try {
      picture::setGraphicsLibrary(library);
    } catch (const InputError& error) {
      ++missing;
      EXPECT_THAT(error.what(), ::testing::HasSubstr(message));
    }
  }
  EXPECT_LT(missing, 2);
}

TEST(Context, LeavesTheUsersNumberOfThreads) {
  ::setenv("LP_NUM_THREADS", "1", 1);
  picture::setRasterThreads(0);
  EXPECT_STREQ(std::getenv("LP_NUM_THREADS"), "1");
  ::unsetenv("LP_NUM_THREADS");
  picture::setRasterThreads(0);
  EXPECT_STREQ(std::getenv("LP_NUM_THREADS"), "0");
}

TEST(Program, ReportsTheCompilersWordsInOneLine) {
  const picture::Context context;
  EXPECT_NO_THROW(picture::Program(kVertexShader, kFragmentShader));
  const std::string message = test::refusalOf<OutputError>([] {
    const picture::Program program(kVertexShader,
                                   "#version 330 core\nvoid main() { colour = 1.0; }\n");
  });
  EXPECT_THAT(message, StartsWith("error: the OpenGL driver refuses a shader ("));
  EXPECT_THAT(message, ::testing::HasSubstr("colour"));
  EXPECT_THAT(message, EndsWith("); install Debian's libosmesa6, version 22.3 or later"));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST(Program, ReportsShadersThatDoNotFitTogether) {
  const picture::Context context;
  const std::string message = test::refusalOf<OutputError>([] {
    const picture::Program program(
        "#version 330 core\nout vec2 shade;\nvoid main() { shade = vec2(0.0); gl_Position = "
        "vec4(0.0); }\n",
        "#version 330 core\nin vec4 shade;\nout vec4 colour;\nvoid main() { colour = shade; }\n");
  });
  EXPECT_THAT(message, StartsWith("error: the OpenGL driver refuses a shader ("));
}

TEST(Framebuffer, RefusesMoreThanTheDriverHas) {
  const picture::Context context;
  const std::string message =
      test::refusalOf<OutputError>([] { const picture::Framebuffer buffer(20000, 10); });
  EXPECT_THAT(message, StartsWith("error: the OpenGL driver cannot draw 20000 x 10 samples"));
  EXPECT_THAT(message, EndsWith("choose a smaller picture with --size"));
}

}  // namespace
}  // namespace kirireel
