#include "adaptive/symmetric.h"

#include <algorithm>
#include <cmath>

namespace weft::adaptive {

std::array<double, most_axes> eigen(Matrix m, size_t n, Matrix& vectors) {
    vectors = {};
    double all = 0;
    for (size_t i = 0; i < n; ++i) {
        vectors[i][i] = 1;
        for (size_t j = 0; j < n; ++j) all += m[i][j] * m[i][j];
    }
    for (int sweep = 0; sweep < 32; ++sweep) {
        double off = 0;
        for (size_t p = 0; p < n; ++p)
            for (size_t q = p + 1; q < n; ++q) off += m[p][q] * m[p][q];
        if (off <= 1e-26 * all) break;
        for (size_t p = 0; p < n; ++p)
            for (size_t q = p + 1; q < n; ++q) {
                if (m[p][q] == 0) continue;
                // The rotation that makes (p, q) zero, by the smaller angle.
                const double ratio = (m[q][q] - m[p][p]) / (2 * m[p][q]);
                const double tangent =
                    (ratio >= 0 ? 1 : -1) / (std::abs(ratio) + std::sqrt(1 + ratio * ratio));
                const double c = 1 / std::sqrt(1 + tangent * tangent), s = tangent * c;
                for (size_t k = 0; k < n; ++k) {
                    const double a = m[k][p], b = m[k][q];
                    m[k][p] = c * a - s * b;
                    m[k][q] = s * a + c * b;
                }
                for (size_t k = 0; k < n; ++k) {
                    const double a = m[p][k], b = m[q][k];
                    m[p][k] = c * a - s * b;
                    m[q][k] = s * a + c * b;
                    const double u = vectors[k][p], v = vectors[k][q];
                    vectors[k][p] = c * u - s * v;
                    vectors[k][q] = s * u + c * v;
                }
            }
    }
    std::array<double, most_axes> values{};
    for (size_t i = 0; i < n; ++i) values[i] = m[i][i];
    return values;
}

void factor(Matrix& m, size_t n) {
    double least = 1e-300;
    for (size_t i = 0; i < n; ++i) least = std::max(least, 1e-12 * m[i][i]);
    factor(m, n, least);
}

void factor(Matrix& m, size_t n, double least) {
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j <= i; ++j) {
            double sum = m[i][j];
            for (size_t k = 0; k < j; ++k) sum -= m[i][k] * m[j][k];
            m[i][j] = i == j ? std::sqrt(std::max(sum, least)) : sum / m[j][j];
        }
}

std::array<double, most_axes> solve_factored(const Matrix& m, size_t n,
                                             std::array<double, most_axes> b) {
    for (size_t i = 0; i < n; ++i) {
        for (size_t k = 0; k < i; ++k) b[i] -= m[i][k] * b[k];
        b[i] /= m[i][i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; ++k) b[i] -= m[k][i] * b[k];
        b[i] /= m[i][i];
    }
    return b;
}

}  // namespace weft::adaptive
