// Compares sparse Cholesky factorisations of a step of joined tiles: BlockCholesky, CHOLMOD
// (supernodal, ordered by AMD or METIS) and Eigen's SimplicialLDLT (AMD), on the matrices of the
// joint solver,
//   H = M + kappa J^T J,
// for sheets of n x n unit squares that are joined at their corners: blocks of 3 in the plane (2
// rows a joint) and of 6 in space (3 rows at each face). The order is found once; what a step pays
// again and again is one factorisation and one solve. CPU time of one thread, the median of runs
// that take turns.
//
//     build/release/tests/bench/cholesky [--runs N] [--tiles N ...]
//
// CHOLMOD is in Debian's libsuitesparse-dev, its BLAS is that of libblas.so.3.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <Eigen/SparseCholesky>
#include <cholmod.h>
#include <fmt/format.h>

#include "sim/mechanics/block_cholesky.h"
#include "sim/mechanics/step_system.h"

namespace kirireel {
namespace {

constexpr double kKappa = 1e4;       // of the joints against masses of 1 kg
constexpr double kThickness = 0.1;   // of the tiles, in edges
constexpr double kExtent = 1.0 / 6;  // inertia of a unit square about its middle

/// Two tiles that share a corner, and the arms of the corner in both.
struct SharedCorner {
  int a = 0, b = 0;
  Vector3 armA, armB;
};

/// The corners at which a sheet of n x n rotating squares is joined.
std::vector<SharedCorner> cornersOf(int n) {
  std::vector<SharedCorner> corners;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const int tile = y * n + x;
      // Slits alternate. Neighbours then keep one corner of their common side.
      const double side = (x + y) % 2 == 0 ? 0.5 : -0.5;
      if (x + 1 < n) corners.push_back({tile, tile + 1, {0.5, side, 0}, {-0.5, side, 0}});
      if (y + 1 < n) corners.push_back({tile, tile + n, {-side, 0.5, 0}, {-side, -0.5, 0}});
    }
  }
  return corners;
}

/// H as blocks, for all factorisations.
template <int D>
struct Blocks {
  using Block = Eigen::Matrix<double, D, D>;
  std::vector<Block, Eigen::aligned_allocator<Block>> diagonal, between;
  std::vector<std::pair<int, int>> edges;
};

template <int D>
Blocks<D> matrixOf(int n) {
  using Space = Coordinates<D>;
  const Matrix3 inertia = Vector3(0.5, 0.5, 1).asDiagonal() * kExtent;
  Blocks<D> h;
  h.diagonal.assign(std::size_t(n) * n, Space::inertia(1, inertia, Matrix3::Identity()));
  for (const SharedCorner& corner : cornersOf(n)) {
    typename Blocks<D>::Block between = Blocks<D>::Block::Zero();
    for (const double z : {0.0, kThickness}) {
      if (D == 3 && z > 0) continue;
      const auto a = Space::pointVelocity(corner.armA + Vector3(0, 0, z));
      const auto b = Space::pointVelocity(corner.armB + Vector3(0, 0, z));
      h.diagonal[std::size_t(corner.a)] += kKappa * a.transpose() * a;
      h.diagonal[std::size_t(corner.b)] += kKappa * b.transpose() * b;
      between -= kKappa * a.transpose() * b;
    }
    h.edges.push_back({corner.a, corner.b});
    h.between.push_back(between);
  }
  return h;
}

template <int D>
Eigen::SparseMatrix<double> lowerTriangle(const Blocks<D>& h) {
  std::vector<Eigen::Triplet<double>> values;
  const auto add = [&](int row, int column, double value) {
    if (row >= column) values.emplace_back(row, column, value);
  };
  for (std::size_t node = 0; node < h.diagonal.size(); ++node) {
    for (int i = 0; i < D; ++i) {
      for (int j = 0; j < D; ++j) add(D * int(node) + i, D * int(node) + j, h.diagonal[node](i, j));
    }
  }
  for (std::size_t e = 0; e < h.edges.size(); ++e) {
    const auto [a, b] = h.edges[e];  // a < b: the block below the diagonal is the transpose
    for (int i = 0; i < D; ++i) {
      for (int j = 0; j < D; ++j) add(D * b + j, D * a + i, h.between[e](i, j));
    }
  }
  const auto size = Eigen::Index(D * h.diagonal.size());
  Eigen::SparseMatrix<double> lower(size, size);
  lower.setFromTriplets(values.begin(), values.end());
  return lower;
}

/// One method to factor and solve. Each call does the work of one step: values, factorisation,
/// solve.
struct Contender {
  std::string name;
  std::function<void()> analyze;
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> step;
  std::vector<double> times = {};
  double analysis = 0;
};

template <int D>
Contender ours(const Blocks<D>& h) {
  const auto matrix = std::make_shared<BlockCholesky<D>>();
  return {"BlockCholesky", [&h, matrix] { matrix->analyze(int(h.diagonal.size()), h.edges); },
          [&h, matrix](const Eigen::VectorXd& right) {
            matrix->setZero();
            for (std::size_t i = 0; i < h.diagonal.size(); ++i) {
              matrix->addToDiagonal(int(i), h.diagonal[i]);
            }
            for (std::size_t e = 0; e < h.edges.size(); ++e) {
              matrix->addToOffDiagonal(int(e), h.between[e]);
            }
            if (!matrix->factor()) throw std::runtime_error("BlockCholesky failed");
            Eigen::VectorXd x = right;
            matrix->solveInPlace(x);
            return x;
          }};
}

Contender eigens(const Eigen::SparseMatrix<double>& lower) {
  const auto factors =
      std::make_shared<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>>();
  return {"Eigen SimplicialLDLT, AMD", [&lower, factors] { factors->analyzePattern(lower); },
          [&lower, factors](const Eigen::VectorXd& right) {
            factors->factorize(lower);
            return Eigen::VectorXd(factors->solve(right));
          }};
}

/// CHOLMOD with one order. Its matrix is a view of Eigen's.
class Cholmod {
 public:
  Cholmod(const Eigen::SparseMatrix<double>& lower, int ordering) {
    cholmod_start(&common_);
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.nmethods = 1;
    common_.method[0].ordering = ordering;
    common_.postorder = 1;
    view_.nrow = view_.ncol = std::size_t(lower.rows());
    view_.nzmax = std::size_t(lower.nonZeros());
    view_.p = const_cast<int*>(lower.outerIndexPtr());
    view_.i = const_cast<int*>(lower.innerIndexPtr());
    view_.x = const_cast<double*>(lower.valuePtr());
    view_.stype = -1;
    view_.itype = CHOLMOD_INT;
    view_.xtype = CHOLMOD_REAL;
    view_.dtype = CHOLMOD_DOUBLE;
    view_.sorted = view_.packed = 1;
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;
  ~Cholmod() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }

  void analyze() {
    cholmod_free_factor(&factor_, &common_);
    factor_ = cholmod_analyze(&view_, &common_);
  }

  Eigen::VectorXd step(const Eigen::VectorXd& right) {
    cholmod_factorize(&view_, factor_, &common_);
    cholmod_dense b{};
    b.nrow = b.nzmax = b.d = std::size_t(right.size());
    b.ncol = 1;
    b.x = const_cast<double*>(right.data());
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    cholmod_dense* x = cholmod_solve(CHOLMOD_A, factor_, &b, &common_);
    const Eigen::VectorXd result =
        Eigen::Map<const Eigen::VectorXd>(static_cast<double*>(x->x), right.size());
    cholmod_free_dense(&x, &common_);
    return result;
  }

 private:
  cholmod_common common_{};
  cholmod_sparse view_{};
  cholmod_factor* factor_ = nullptr;
};

Contender cholmods(const std::string& name, const Eigen::SparseMatrix<double>& lower,
                   int ordering) {
  const auto cholmod = std::make_shared<Cholmod>(lower, ordering);
  return {name, [cholmod] { cholmod->analyze(); },
          [cholmod](const Eigen::VectorXd& right) { return cholmod->step(right); }};
}

/// CPU milliseconds of this thread.
double now() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * double(time.tv_sec) + 1e-6 * double(time.tv_nsec);
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

template <int D>
void printRows(int tiles, int runs) {
  const int n = int(std::lround(std::sqrt(tiles)));
  const Blocks<D> h = matrixOf<D>(n);
  const Eigen::SparseMatrix<double> lower = lowerTriangle(h);
  std::vector<Contender> contenders{
      ours(h), cholmods("CHOLMOD supernodal, AMD", lower, CHOLMOD_AMD),
      cholmods("CHOLMOD supernodal, METIS", lower, CHOLMOD_METIS), eigens(lower)};
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(lower.rows(), -1, 1);
  for (Contender& contender : contenders) {
    const double start = now();
    contender.analyze();
    contender.analysis = now() - start;
  }
  double residual = 0;
  for (int run = 0; run < runs; ++run) {
    for (Contender& contender : contenders) {
      const double start = now();
      const Eigen::VectorXd x = contender.step(right);
      contender.times.push_back(now() - start);
      const Eigen::VectorXd left = lower.selfadjointView<Eigen::Lower>() * x;
      residual = std::max(residual, (left - right).norm() / right.norm());
    }
  }
  const double best = median(contenders[0].times);
  for (const Contender& contender : contenders) {
    const double time = median(contender.times);
    fmt::print("{:<6} {:>6}  {:<26} {:>10.2f} {:>10.3f} {:>8.2f}\n", D == 3 ? "plane" : "space",
               n * n, contender.name, contender.analysis, time, time / best);
  }
  fmt::print("{:<15}largest residual {:.1e}\n", "", residual);
}

}  // namespace
}  // namespace kirireel

int main(int argc, char** argv) {
  CLI::App app(
      "Times of sparse Cholesky factorisations on the matrices of the joint solver. CHOLMOD is in "
      "Debian's libsuitesparse-dev; install libopenblas0-serial for the BLAS that suits it.");
  std::vector<int> tiles{100, 400, 1600, 10000};
  int runs = 15;
  app.add_option("--tiles", tiles, "sizes of sheets, rounded to squares of numbers");
  app.add_option("--runs", runs, "of each, taking turns")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  fmt::print("{:<6} {:>6}  {:<26} {:>10} {:>10} {:>8}\n", "", "tiles", "", "order ms", "step ms",
             "of ours");
  for (const int count : tiles) kirireel::printRows<3>(count, runs);
  for (const int count : tiles) kirireel::printRows<6>(count, runs);
  return 0;
}
