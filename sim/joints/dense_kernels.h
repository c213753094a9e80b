/// The dense inner loops of the factorisation, in versions for older and newer processors.
#pragma once

namespace kirireel {

/// Works on one front's panel: column-major, `columns` wide; its first `columns` rows are the pivot
/// block (lower triangle), the rows below it follow.
struct DenseKernels {
  /// Factors the pivot block in place, divides the rows below by it, and takes their product off
  /// `update` (lower triangle, square, rows - columns wide). Returns false when the pivot block is
  /// not positive definite.
  bool (*eliminate)(double* panel, int rows, int columns, double* update);

  /// top = L^-1 top; below = (rows below) * top.
  void (*solveForward)(const double* panel, int rows, int columns, double* top, double* below);

  /// top = L^-T (top - (rows below)^T * below).
  void (*solveBackward)(const double* panel, int rows, int columns, double* top,
                        const double* below);

  const char* name;  ///< of the instruction set
};

/// The fastest kernels that this processor can run: AVX2 with fused multiply-add where it has them.
/// Results differ in the last bits between the two sets, never between runs on one machine.
const DenseKernels& denseKernels();

namespace baseline {
extern const DenseKernels kKernels;
}
namespace avx2 {
extern const DenseKernels kKernels;
}

}  // namespace kirireel
