// Receivers of a batch on a light's film, and which of a pixel's locations ask the light for others.
#include <gtest/gtest.h>

#include "shadows/receivers.h"
#include "tests/instruction_sets.h"

namespace weft {
namespace {
using namespace shadows;

// What a location sees, in light space: a place and the normal of its surface.
struct Place {
    std::array<float, 3> at, normal;
};
constexpr std::array<float, 3> level{0, 0, -1};

LightView quad_view() {
    LightView view;
    view.shape = LightView::Shape::quad;
    view.ax = view.ay = 1;
    view.k = 100, view.focus = 7.5, view.nearest = 0.01;
    view.width = view.height = 200;
    view.cx = view.cy = 100;
    return view;
}

// Of batches of `together` locations a pixel, whose answer holds for each. All look at the light from (0.4, -0.7).
ShadowQueries asked(const std::vector<Place>& places, size_t together) {
    ReceiverBatch batch;
    batch.resize(places.size(), false);
    Locations at;
    at.shared = true;
    at.together = together;
    at.u = {0.4f}, at.v = {-0.7f}, at.t = {0.5f};
    at.x.resize(places.size()), at.y.resize(places.size());
    for (size_t l = 0; l < places.size(); ++l) {
        const auto& [p, normal] = places[l];
        batch.x[l] = p[0], batch.y[l] = p[1], batch.w[l] = p[2];
        batch.normal_x[l] = normal[0], batch.normal_y[l] = normal[1], batch.normal_w[l] = normal[2];
    }
    ShadowQueries ask;
    WEFT_PICK(look_from_light)(quad_view(), batch, at, ask);
    return ask;
}
std::vector<std::uint32_t> answers(const std::vector<Place>& places, size_t together) {
    const ShadowQueries ask = asked(places, together);
    // Those that have another's answer do not ask.
    for (size_t l = 0; l < ask.answer_of.size(); ++l) {
        if (ask.answer_of[l] == l) continue;
        EXPECT_EQ(ask.inverse_depth[l], 0) << l;
    }
    return ask.answer_of;
}
using Answers = std::vector<std::uint32_t>;

class ReceiversOfAPixel : public testing::TestWithParam<Isa> {
    const PinnedIsa pinned{GetParam()};
};

TEST_P(ReceiversOfAPixel, AskOnceForTheirSurface) {
    const Place floor{{0, 0, 10}, level}, beside{{0.05f, -0.02f, 10}, level};
    EXPECT_EQ(answers({floor, floor}, 2), (Answers{0, 0}));
    EXPECT_EQ(answers({floor, beside}, 2), (Answers{0, 0}));
    // Two pixels: first locations, then second ones.
    const Place other{{2, 1, 10}, level};
    EXPECT_EQ(answers({floor, other, beside, other}, 2), (Answers{0, 1, 0, 1}));
    // Planes that are tilted, as the light's point sees them.
    const float rise = 0.5f;  // w a unit of x
    const std::array<float, 3> tilted{rise, 0, -1};
    const auto on_slope = [&](float x) { return Place{{x, 0, 10 + rise * x}, tilted}; };
    EXPECT_EQ(answers({on_slope(-1), on_slope(-0.9f)}, 2), (Answers{0, 0}));
    EXPECT_EQ(answers({on_slope(-1), {{-0.9f, 0, 9.3f}, tilted}}, 2), (Answers{0, 1}));
}

TEST_P(ReceiversOfAPixel, AskForThemselvesWhereTheySeeAnother) {
    const Place floor{{0, 0, 10}, level}, before{{0, 0, 8}, level}, little{{0.01f, 0, 9.9f}, level};
    EXPECT_EQ(answers({floor, before}, 2), (Answers{0, 1}));
    EXPECT_EQ(answers({floor, little}, 2), (Answers{0, 1}));
    EXPECT_EQ(answers({before, floor}, 2), (Answers{0, 1}));
    // The third takes the answer of the one whose surface it sees.
    EXPECT_EQ(answers({floor, before, before, floor}, 4), (Answers{0, 1, 1, 0}));
}

TEST_P(ReceiversOfAPixel, AskForThemselvesWhereTheFirstDoesNot) {
    const Place floor{{0, 0, 10}, level}, outside{{90, 0, 10}, level}, sky{{0, 0, 0}, {}};
    EXPECT_EQ(answers({sky, floor}, 2), (Answers{0, 1}));
    EXPECT_EQ(answers({outside, floor, floor}, 3), (Answers{0, 1, 1}));
    EXPECT_EQ(asked({outside, outside}, 2).outside, 2u);
    EXPECT_EQ(answers({floor, sky}, 2), (Answers{0, 1}));
}

TEST_P(ReceiversOfAPixel, AskForThemselvesInBatchesOfOneEach) {
    const Place floor{{0, 0, 10}, level};
    const ShadowQueries ask = asked({floor, floor}, 1);
    EXPECT_TRUE(ask.answer_of.empty());
    EXPECT_GT(ask.inverse_depth[1], 0);
}

INSTANTIATE_TEST_SUITE_P(Isa, ReceiversOfAPixel, testing::ValuesIn(instruction_sets()),
                         [](const auto& of) { return std::string(name_of(of.param)); });

}  // namespace
}  // namespace weft
