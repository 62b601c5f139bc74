// Small symmetric matrices, most_axes x most_axes at most: eigenvalues and linear systems.
#pragma once
#include <array>
#include <cstddef>

#include "adaptive/adaptive_tree.h"

namespace weft::adaptive {

using Matrix = std::array<std::array<double, most_axes>, most_axes>;

// Eigenvalues of the first n rows and columns of `m`, with their vectors as columns of `vectors`.
// Source: Jacobi 1846; cyclic sweeps, Golub and Van Loan 1996, Sec. 8.4.
std::array<double, most_axes> eigen(Matrix m, size_t n, Matrix& vectors);

// Cholesky's factor of a positive definite m, in its lower triangle; no pivot is below `least`, by
// default what rounding leaves of the largest element: of a singular m nothing is divided by that.
void factor(Matrix& m, size_t n);
void factor(Matrix& m, size_t n, double least);
// x of m x = b, given that factor.
std::array<double, most_axes> solve_factored(const Matrix& factor, size_t n,
                                             std::array<double, most_axes> b);

}  // namespace weft::adaptive
