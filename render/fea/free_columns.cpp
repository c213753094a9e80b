// A multifrontal QR factorisation of J with column pivoting within each tile (T. A. Davis,
// Algorithm 915, SuiteSparseQR: multifrontal multithreaded rank-revealing sparse QR factorization,
// ACM Trans. Math. Softw. 38, 2011; the test of rank is Heath's, section 2.6 there). Tiles are
// eliminated in the order and the fronts of sim/joints/elimination.h, which holds for QR too: J^T J
// has the graph of the tiles.
//
// A front holds the equations that touch its own tiles F and what its children left over.
// Householder reflections make F upper trapezoidal, for each tile its longest remaining column
// first:
//
//     [ F | G ]  ->  [ R  S ]     R: eliminated columns, done with
//                    [ 0  L ]     L: left over, for the parent; never more rows than columns
//
// Where the columns that remain of a tile are shorter than the tolerance, they depend on those
// before: their unknowns are free, and the columns are left out, which is to hold them at zero. J
// is never squared, so that a column that strains nothing is left with rounding, 1e-16 times the
// length of the motion that it belongs to, and not with the root of that.
#include "render/fea/free_columns.h"

#include <algorithm>

#include <Eigen/QR>

#include "sim/joints/elimination.h"

namespace kirireel {
namespace {

constexpr Eigen::Index kUnknowns = 6;

class FrontalElimination {
 public:
  FrontalElimination(int tileCount, const std::vector<PairEquations>& equations,
                     const std::vector<bool>& isFixed, double tolerance)
      : equations_(equations), isFixed_(isFixed), tolerance_(tolerance), tileAt_(tileCount) {
    std::vector<std::pair<int, int>> edges;
    // The graph has a vertex a tile and an edge a pair that equations connect. Its fill is that of
    // a Cholesky factorisation of J^T J.
    for (const PairEquations& pair : equations) {
      if (pair.firstTile != pair.secondTile) edges.emplace_back(pair.firstTile, pair.secondTile);
    }
    plan_ = planElimination(tileCount, edges);
    for (int tile = 0; tile < tileCount; ++tile) tileAt_[plan_.place[tile]] = tile;
    // An equation enters with the first of its tiles that is eliminated.
    equationsAt_.resize(tileCount);
    for (std::size_t k = 0; k < equations.size(); ++k) {
      equationsAt_[std::min(place(equations[k].firstTile), place(equations[k].secondTile))]
          .push_back(k);
    }
    leftOver_.resize(plan_.supernodes.size());
  }

  std::vector<FreeColumn> run() {
    for (std::size_t s = 0; s < plan_.supernodes.size(); ++s) eliminate(s);
    return std::move(free_);
  }

 private:
  int place(int tile) const { return plan_.place[tile]; }

  /// The equations of a front: those of its own tiles, and what its children left over. Columns are
  /// the front's own tiles first, then those of `node.rows`, six each. A child's rest has the
  /// columns of its own `rows`, whose places here `childPlaces` names.
  Eigen::MatrixXd assemble(const Supernode& node) {
    Eigen::Index rows = 0;
    for (const int child : node.children) rows += leftOver_[child].rows();
    for (int c = 0; c < node.columnCount; ++c) {
      for (const std::size_t k : equationsAt_[node.firstColumn + c]) {
        rows += equations_[k].first.rows();
      }
    }
    const auto tiles = node.columnCount + static_cast<Eigen::Index>(node.rows.size());
    Eigen::MatrixXd front = Eigen::MatrixXd::Zero(rows, kUnknowns * tiles);
    Eigen::Index row = 0;
    for (std::size_t c = 0; c < node.children.size(); ++c) {
      Eigen::MatrixXd& part = leftOver_[node.children[c]];
      const std::vector<int>& places = node.childPlaces[c];
      for (std::size_t k = 0; k < places.size(); ++k) {
        front.block(row, kUnknowns * places[k], part.rows(), kUnknowns) =
            part.middleCols<kUnknowns>(kUnknowns * static_cast<Eigen::Index>(k));
      }
      row += part.rows();
      // Memory is given back as fronts are done: no more than one path's rests are kept at a time.
      part.resize(0, 0);
    }
    for (int c = 0; c < node.columnCount; ++c) {
      for (const std::size_t k : equationsAt_[node.firstColumn + c]) {
        const PairEquations& pair = equations_[k];
        place(front, row, node, pair.firstTile, pair.first);
        place(front, row, node, pair.secondTile, pair.second);
        row += pair.first.rows();
      }
    }
    return front;
  }

  /// Adds one tile's side of an equation.
  void place(Eigen::MatrixXd& front, Eigen::Index row, const Supernode& node, int tile,
             const PairEquations::Rows& block) const {
    if (isFixed_[tile]) return;
    // Own tiles follow each other by place; the others are found in the sorted list of rows.
    int column = place(tile) - node.firstColumn;
    if (column >= node.columnCount) {
      const auto found = std::ranges::lower_bound(node.rows, place(tile));
      column = node.columnCount + static_cast<int>(found - node.rows.begin());
    }
    front.block(row, kUnknowns * column, block.rows(), kUnknowns) += block;
  }

  /// Fronts come in an order in which children precede their parents.
  void eliminate(std::size_t number) {
    const Supernode& node = plan_.supernodes[number];
    Eigen::MatrixXd front = assemble(node);
    Eigen::Index row = 0;
    for (int c = 0; c < node.columnCount; ++c) {
      row = eliminateTile(front, row, kUnknowns * c, tileAt_[node.firstColumn + c]);
    }
    const auto own = kUnknowns * static_cast<Eigen::Index>(node.columnCount);
    Eigen::MatrixXd rest = front.bottomRightCorner(front.rows() - row, front.cols() - own);
    // More rows than columns carry no further information: R of their QR has the same J^T J.
    if (rest.rows() > rest.cols()) {
      const Eigen::HouseholderQR<Eigen::MatrixXd> factors(rest);
      rest = factors.matrixQR().topRows(rest.cols()).triangularView<Eigen::Upper>();
    }
    leftOver_[number] = std::move(rest);
  }

  /// Reflects the columns of one tile, from this row and column on. Returns the row after them. The
  /// invariant: the first `row` rows are done, and no later column of this tile reaches above them.
  Eigen::Index eliminateTile(Eigen::MatrixXd& front, Eigen::Index row, Eigen::Index column,
                             int tile) {
    std::array<int, kUnknowns> unknowns = {0, 1, 2, 3, 4, 5};
    for (Eigen::Index k = 0; k < kUnknowns; ++k) {
      const Eigen::Index rows = front.rows() - row;
      Eigen::Index longest = 0;
      double square = 0;
      if (rows > 0) {
        square = front.block(row, column + k, rows, kUnknowns - k)
                     .colwise()
                     .squaredNorm()
                     .maxCoeff(&longest);
      }
      // The longest column is too short, so all that remain are.
      if (square <= tolerance_ * tolerance_) {
        for (; k < kUnknowns && !isFixed_[tile]; ++k) free_.push_back({tile, unknowns[k]});
        break;
      }
      // Pivoting stays within the tile, or the plan of fronts would no longer hold.
      front.col(column + k).swap(front.col(column + k + longest));
      std::swap(unknowns[k], unknowns[k + longest]);
      reflect(front, row++, column + k);
    }
    return row;
  }

  /// Makes one column zero below this row.
  void reflect(Eigen::MatrixXd& front, Eigen::Index row, Eigen::Index column) {
    auto below = front.col(column).tail(front.rows() - row);
    double factor = 0;
    double length = 0;
    below.makeHouseholderInPlace(factor, length);
    const Eigen::VectorXd essential = below.tail(below.size() - 1);
    work_.resize(front.cols());
    front.bottomRightCorner(front.rows() - row, front.cols() - column - 1)
        .applyHouseholderOnTheLeft(essential, factor, work_.data());
  }

  const std::vector<PairEquations>& equations_;
  const std::vector<bool>& isFixed_;
  double tolerance_;
  Elimination plan_;
  std::vector<int> tileAt_;                            ///< by place
  std::vector<std::vector<std::size_t>> equationsAt_;  ///< by place
  std::vector<Eigen::MatrixXd> leftOver_;              ///< by supernode, until its parent takes it
  Eigen::VectorXd work_;
  std::vector<FreeColumn> free_;
};

}  // namespace

std::vector<FreeColumn> freeColumns(int tileCount, const std::vector<PairEquations>& equations,
                                    const std::vector<bool>& isFixed, double tolerance) {
  return FrontalElimination(tileCount, equations, isFixed, tolerance).run();
}

}  // namespace kirireel
