/// The dense inner loops of the factorisation, in versions for older and newer processors.
#pragma once

namespace kirireel::mechanics {

/// The rows of a register. A column of a panel or of an update is padded to whole registers.
inline constexpr int kRowsTogether = 4;

/// The length of a column with `rows` rows, including padding.
[[gnu::always_inline]] inline int paddedRows(int rows) {
  return (rows + kRowsTogether - 1) / kRowsTogether * kRowsTogether;
}

/// Operates on one front's panel: column-major, `columns` wide, a multiple of three. The first
/// `columns` rows are the pivot block. The rows below it follow, and zeros pad its columns. Entries
/// above the diagonal are undefined. kRowsTogether more values must be readable behind a panel and
/// an update.
struct DenseKernels {
  /// Factors the pivot block in place, divides the rows below by it, and subtracts their product
  /// from `update` (lower triangle, square, rows - columns wide, its columns padded). The diagonal
  /// of the factor stores reciprocals. Returns false if the pivot block is not positive definite.
  bool (*eliminate)(double* panel, int rows, int columns, double* update);

  /// For x with one value per row and zeros as padding: top = L^-1 top. Subtracts
  /// (rows below) * top from the rows below.
  void (*solveForward)(const double* panel, int rows, int columns, double* x);

  /// top = L^-T (top - (rows below)^T * below).
  void (*solveBackward)(const double* panel, int rows, int columns, double* x);

  const char* name;  ///< of the instruction set
};

/// The fastest kernels that this processor supports: AVX2 with fused multiply-add if available.
/// Results differ in the last bits between the two sets, never between runs on one machine.
const DenseKernels& denseKernels();

namespace baseline {
/// The loops for any processor of the architecture.
extern const DenseKernels kKernels;
}  // namespace baseline
namespace avx2 {
/// The loops for processors with AVX2 and fused multiply-add.
extern const DenseKernels kKernels;
}  // namespace avx2

}  // namespace kirireel::mechanics
