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

// Solves m x = b for a positive definite m, by Cholesky's method; b becomes x.
void solve(Matrix m, size_t n, std::array<double, most_axes>& b);

}  // namespace weft::adaptive
