#include "sim/mechanics/block_cholesky.h"

#include <random>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "tests/sim/mechanics/graphs.h"

namespace kirireel {
namespace {

using test::Graph;

/// A dense twin of the blocks: sum over edges of rows^T rows, as joints make, plus `shift` on the
/// diagonal.
template <int D>
class BothMatrices {
 public:
  explicit BothMatrices(const Graph& graph) : graph_(graph) {
    sparse.analyze(graph.nodeCount, graph.edges);
  }

  void fill(double shift, unsigned seed) {
    std::srand(seed);
    sparse.setZero();
    dense.setZero(D * graph_.nodeCount, D * graph_.nodeCount);
    for (int i = 0; i < graph_.nodeCount; ++i) addDiagonal(i, shift * Block::Identity());
    for (std::size_t e = 0; e < graph_.edges.size(); ++e) {
      const auto [a, b] = graph_.edges[e];
      const Block rowsA = Block::Random();
      const Block rowsB = Block::Random();
      addDiagonal(a, rowsA.transpose() * rowsA);
      addDiagonal(b, rowsB.transpose() * rowsB);
      const Block between = rowsA.transpose() * rowsB;
      sparse.addToOffDiagonal(static_cast<int>(e), between);
      dense.template block<D, D>(D * a, D * b) += between;
      dense.template block<D, D>(D * b, D * a) += between.transpose();
    }
  }

  /// Distance between the two solutions, relative to the solution.
  double difference() {
    EXPECT_TRUE(sparse.factor());
    const Eigen::VectorXd right = Eigen::VectorXd::Random(D * graph_.nodeCount);
    const Eigen::VectorXd expected = dense.llt().solve(right);
    Eigen::VectorXd found = right;
    sparse.solveInPlace(found);
    return (found - expected).norm() / expected.norm();
  }

  using Block = Eigen::Matrix<double, D, D>;
  mechanics::BlockCholesky<D> sparse;
  Eigen::MatrixXd dense;

 private:
  void addDiagonal(int node, const Block& block) {
    sparse.addToDiagonal(node, block);
    dense.template block<D, D>(D * node, D * node) += block;
  }

  Graph graph_;
};

template <typename T>
class BlockCholeskyOf : public ::testing::Test {};

template <int D>
struct Size {
  static constexpr int value = D;
};

using Sizes = ::testing::Types<Size<3>, Size<6>>;
TYPED_TEST_SUITE(BlockCholeskyOf, Sizes, );

TYPED_TEST(BlockCholeskyOf, MatchesDenseCholeskyOnEveryKindOfGraph) {
  for (const Graph& graph : test::sampleGraphs()) {
    BothMatrices<TypeParam::value> matrices(graph);
    matrices.fill(1.0, 3);
    EXPECT_LT(matrices.difference(), 1e-13) << graph.name;  // measured 6e-16
  }
}

TYPED_TEST(BlockCholeskyOf, KeepsItsDigitsUnderStiffJoints) {
  for (const Graph& graph : test::sampleGraphs()) {
    BothMatrices<TypeParam::value> matrices(graph);
    matrices.fill(1e-8, 5);
    EXPECT_TRUE(matrices.sparse.factor()) << graph.name;
    const Eigen::VectorXd right = matrices.dense * Eigen::VectorXd::Ones(matrices.dense.rows());
    Eigen::VectorXd found = right;
    matrices.sparse.solveInPlace(found);
    const double residual = (matrices.dense * found - right).norm();
    EXPECT_LT(residual, 1e-13 * right.norm() * found.norm())
        << graph.name;  // measured 4e-14 unscaled
  }
}

TYPED_TEST(BlockCholeskyOf, NewValuesOnTheSamePlanReplaceTheOldOnes) {
  BothMatrices<TypeParam::value> matrices(test::gridGraph(6, 5));
  matrices.fill(1.0, 1);
  EXPECT_LT(matrices.difference(), 1e-13);
  matrices.fill(0.3, 2);
  EXPECT_LT(matrices.difference(), 1e-13);
}

TYPED_TEST(BlockCholeskyOf, IsPlannedAnewForMoreEdges) {
  Graph graph = test::gridGraph(6, 5);
  BothMatrices<TypeParam::value> before(graph);
  before.fill(1.0, 1);
  graph.edges.insert(graph.edges.end(), {{0, 29}, {17, 3}, {0, 29}, {28, 1}});
  BothMatrices<TypeParam::value> after(graph);
  after.sparse = before.sparse;
  after.sparse.analyze(graph.nodeCount, graph.edges);
  after.fill(1.0, 1);
  EXPECT_LT(after.difference(), 1e-13);
}

TYPED_TEST(BlockCholeskyOf, TellsThatAMatrixIsNotPositiveDefinite) {
  using Block = typename BothMatrices<TypeParam::value>::Block;
  for (const Graph& graph : test::sampleGraphs()) {
    for (const double bad : {-1.0, 0.0}) {
      BothMatrices<TypeParam::value> matrices(graph);
      matrices.fill(1.0, 3);
      const int node = graph.nodeCount / 2;
      constexpr int kSize = TypeParam::value;
      const Block whole = matrices.dense.template block<kSize, kSize>(kSize * node, kSize * node);
      Block diagonal = whole;
      diagonal.col(1).setZero();
      diagonal.row(1).setZero();
      diagonal(1, 1) = bad;
      matrices.sparse.addToDiagonal(node, diagonal - whole);
      EXPECT_FALSE(matrices.sparse.factor()) << graph.name << ", " << bad;
    }
  }
}

TYPED_TEST(BlockCholeskyOf, GivesTheSameBytesAgain) {
  BothMatrices<TypeParam::value> first(test::gridGraph(9, 7));
  BothMatrices<TypeParam::value> second(test::gridGraph(9, 7));
  first.fill(1e-6, 4);
  second.fill(1e-6, 4);
  ASSERT_TRUE(first.sparse.factor() && second.sparse.factor());
  second.fill(1e-6, 4);
  ASSERT_TRUE(second.sparse.factor());
  Eigen::VectorXd a = Eigen::VectorXd::Ones(first.dense.rows());
  Eigen::VectorXd b = a;
  first.sparse.solveInPlace(a);
  second.sparse.solveInPlace(b);
  EXPECT_TRUE((a.array() == b.array()).all());
}

}  // namespace
}  // namespace kirireel
