// merge-samples: every sample once, in its pixel.
#include "samples/samples.h"
#include "tests/run_node.h"

namespace weft {
namespace {

Samples buffer(std::vector<std::uint64_t> first, float value) {
    Samples samples;
    samples.width = int(first.size()) - 1, samples.height = 1;
    samples.set_size(first.back());
    std::vector<float> t(first.back());
    std::vector<std::uint32_t> id(first.back());
    for (size_t i = 0; i < t.size(); ++i) t[i] = value + float(i), id[i] = std::uint32_t(t[i]);
    samples.first = std::move(first);
    samples.add("t", 1, std::move(t));
    samples.add_ids("id", std::move(id));
    return samples;
}

TEST(MergeSamples, puts_a_pixels_samples_together) {
    const Samples a = buffer({0, 1, 1, 3}, 0), b = buffer({0, 2, 2, 2}, 10),
                  none = buffer({0, 0, 0, 0}, 20);
    Samples out = RunNode("merge-samples")
                      .in("samples", a)
                      .in("samples", b)
                      .in("samples", none)
                      .out<Samples>("samples");
    ASSERT_EQ(out.size(), 5u);
    const std::vector<float> expected = {0, 10, 11, 1, 2};
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), out.t().begin()));
    EXPECT_EQ(out.of_pixel(0).end, 3u);
    EXPECT_EQ(out.of_pixel(1).end, 3u);
    EXPECT_EQ(out.find("id")->ids[2], 11u);
    // As many everywhere: spp says so.
    out = RunNode("merge-samples")
              .in("samples", buffer({0, 1, 2}, 0))
              .in("samples", buffer({0, 1, 2}, 5))
              .out<Samples>("samples");
    EXPECT_EQ(out.spp, 2);
    EXPECT_TRUE(out.first.empty());
}

TEST(MergeSamples, keeps_what_all_have_and_refuses_another_picture) {
    Samples a = buffer({0, 1}, 0), b = buffer({0, 1}, 1);
    a.add("z", 1, {3});
    const Samples out =
        RunNode("merge-samples").in("samples", a).in("samples", b).out<Samples>("samples");
    EXPECT_EQ(out.find("z"), nullptr);
    EXPECT_NE(error_of([&] {
                  RunNode("merge-samples")
                      .in("samples", a)
                      .in("samples", buffer({0, 1, 1}, 0))
                      .out<Samples>("samples");
              }).find("2 x 1, the first buffer 1 x 1"),
              std::string::npos);
}

}  // namespace
}  // namespace weft
