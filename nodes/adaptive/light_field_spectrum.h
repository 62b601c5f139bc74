// A window of a light field over one axis of the film and time, or the lens, and its spectrum.
//   cells   means of samples, minus the mean of all, under a raised cosine over both axes, so that
//           the window's own sides do not show; empty cells are as their column's mean
//   spectrum |F|, F(X, Y) = sum of cells exp(-2 pi j (X x + Y y)), by plain sums: windows are small
// Source: the transform's definition; Egan et al. 2009, Sec. 3, for what it shows.
#pragma once
#include <span>
#include <vector>

namespace weft::adaptive {

struct LightFieldWindow {
    int width = 0, height = 0;      // cells over the film, over time or lens
    double cell_x = 1, cell_y = 1;  // px; shutters or units of lens
    std::vector<double> value;      // row by row
    double at(int x, int y) const { return value[size_t(y) * size_t(width) + size_t(x)]; }
};

// Of (place from the window's side, px; window coordinate in [0, 1); value), one a sample.
struct WindowPoint {
    double x, y, value;
};
LightFieldWindow light_field_window(std::span<const WindowPoint> points, int width, double px,
                                    int height, double extent);

// At frequencies evenly spaced over [-limit_x, limit_x] x [-limit_y, limit_y], cycles a px and a
// unit of the other axis; size x size values, Y upwards.
std::vector<double> amplitudes(const LightFieldWindow& window, int size, double limit_x,
                               double limit_y);

}  // namespace weft::adaptive
