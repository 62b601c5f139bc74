#include "samples/convert.h"

#include <Imath/half.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <vector>

namespace weft {
namespace {

TEST(Halves, all_65536_are_the_floats_they_should_be) {
    std::vector<std::uint16_t> halves(65536);
    for (size_t i = 0; i < halves.size(); ++i) halves[i] = std::uint16_t(i);
    std::vector<float> floats(halves.size());
    floats_from_halves({reinterpret_cast<const std::uint8_t*>(halves.data()), 2 * halves.size()},
                       floats);
    for (size_t i = 0; i < halves.size(); ++i) {
        Imath::half half;
        half.setBits(halves[i]);
        const float expected = half;
        if (std::isnan(expected)) {
            EXPECT_TRUE(std::isnan(floats[i])) << i;
        } else {
            EXPECT_EQ(std::bit_cast<std::uint32_t>(floats[i]),
                      std::bit_cast<std::uint32_t>(expected))
                << i;
        }
    }
}

}  // namespace
}  // namespace weft
