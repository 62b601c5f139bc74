// Renderers that are not ours: graphs, child processes, and those that can only be asked in steps.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "adaptive/leaf_tree.h"
#include "adaptive/sampler_function.h"
#include "image/image.h"
#include "samples/samples.h"
#include "tests/run_node.h"

namespace weft {
namespace {

Json words(std::initializer_list<std::string> list) {
    Json json = Json::list();
    for (const std::string& word : list) json.items.emplace_back(word);
    return json;
}
Json numbers(std::initializer_list<double> list) {
    Json json = Json::list();
    for (const double number : list) json.items.emplace_back(number);
    return json;
}

struct Sampled {
    Samples samples;
    LeafTree leaves;
    std::vector<std::string> warnings;
};
Sampled run_for(RunNode& node) {
    Sampled made;
    node.run({Slot{"samples", &type_info<Samples>(), &made.samples, {}}, Slot{"leaves", &type_info<LeafTree>(), &made.leaves, {}}});
    made.warnings = node.ctx.warnings;
    return made;
}
Sampled adaptive(const SamplerFunction& sampler, double budget = 4, const char* reach = "leaf") {
    RunNode node("adaptive-samples");
    node.in("sampler", sampler).set("budget", Json(budget)).set("reach", Json(reach));
    return run_for(node);
}
void expect_same_bits(const Samples& a, const Samples& b) {
    ASSERT_EQ(a.size(), b.size());
    ASSERT_EQ(a.channels.size(), b.channels.size());
    for (const Channel& channel : a.channels) {
        const Channel* other = b.find(channel.name);
        ASSERT_TRUE(other) << channel.name;
        ASSERT_EQ(channel.values.size(), other->values.size()) << channel.name;
        for (size_t i = 0; i < channel.values.size(); ++i) ASSERT_EQ(channel.values[i], other->values[i]) << channel.name << " " << i;
    }
}
// The same bits through a file.
Samples through_file(const Samples& samples) {
    TestFolder folder;
    RunNode("write-samples").in("samples", samples).set("file", Json(folder / "s.npz")).run();
    return RunNode("read-samples").set("file", Json(folder / "s.npz")).set("channels", words({"*"})).out<Samples>("samples");
}

struct Step {
    Samples state, requests;
};
Step take(RunNode& node) {
    Step made;
    node.run({Slot{"state", &type_info<Samples>(), &made.state, {}}, Slot{"requests", &type_info<Samples>(), &made.requests, {}}});
    return made;
}
Step begin(const SamplerFunction& sampler, double budget = 4, const char* reach = "leaf") {
    RunNode node("adaptive-begin");
    node.in("sampler", sampler).set("budget", Json(budget)).set("reach", Json(reach));
    return take(node);
}
Step next(const Samples& state, const Samples& results) {
    RunNode node("adaptive-step");
    node.in("state", state).in("results", results);
    return take(node);
}
Samples evaluated(const SamplerFunction& sampler, const Samples& points) { return RunNode("evaluate-points").in("sampler", sampler).in("points", points).out<Samples>("samples"); }

SamplerFunction disc(int side = 48) {
    return RunNode("test-sampler").set("width", Json(double(side))).set("height", Json(double(side))).out<SamplerFunction>("sampler");
}

class StepsOfReach : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, StepsOfReach, testing::Values("leaf", "neighbours"));

TEST_P(StepsOfReach, GiveTheBitsOfTheCallableForm) {
    const SamplerFunction sampler = disc(40);
    const Sampled whole = adaptive(sampler, 4, GetParam());
    Step at = begin(sampler, 4, GetParam());
    size_t steps = 0;
    for (; at.requests.size() > 0; ++steps) {
        // State and requests go through files, as on a farm; results come in another order.
        const Samples results = evaluated(sampler, through_file(at.requests));
        at = next(through_file(at.state), through_file(results));
    }
    EXPECT_GT(steps, 4u);
    RunNode end("adaptive-end");
    end.in("state", at.state);
    const Sampled pieces = run_for(end);
    expect_same_bits(whole.samples, pieces.samples);
    EXPECT_EQ(whole.leaves.lo, pieces.leaves.lo);
    EXPECT_EQ(whole.leaves.hi, pieces.leaves.hi);
    EXPECT_EQ(whole.leaves.samples, pieces.leaves.samples);
    EXPECT_EQ(whole.leaves.error, pieces.leaves.error);
}

TEST(AdaptiveSteps, SayWhatIsWrongWithResults) {
    const SamplerFunction sampler = disc(16);
    const Step first = begin(sampler);
    const Samples good = evaluated(sampler, first.requests);
    const auto said = [&](const Samples& results) { return error_of([&] { next(first.state, results); }); };
    EXPECT_EQ(said(good), "");
    const auto with = [&](auto change) {
        std::vector<std::uint32_t> ids(good.find("request")->ids.view().begin(), good.find("request")->ids.view().end());
        change(ids);
        Samples bad = good;
        bad.add_ids("request", ids);
        return bad;
    };
    EXPECT_NE(said(with([](auto& ids) { ids[3] = ids[4]; })).find("answered twice"), std::string::npos);
    EXPECT_NE(said(with([](auto& ids) { ids[3] = 4000000; })).find("answers request 4000000, which was not asked for"), std::string::npos);
    Samples nameless = good;
    std::erase_if(nameless.channels, [](const Channel& c) { return c.name == "request"; });
    EXPECT_NE(said(nameless).find("'request'"), std::string::npos);
    Samples dark = good;
    std::erase_if(dark.channels, [](const Channel& c) { return c.name == "rgb"; });
    EXPECT_NE(said(dark).find("no 'rgb'"), std::string::npos);
    // One pixel's results alone.
    Samples few = evaluated(sampler, first.requests);
    Samples part = few;
    part.set_size(few.size() - 1);
    std::vector<float> rgb(few.rgb().begin(), few.rgb().end() - 3);
    std::vector<std::uint32_t> ids(few.find("request")->ids.view().begin(), few.find("request")->ids.view().end() - 1);
    part.channels.clear();
    part.add("rgb", 3, rgb);
    part.add_ids("request", ids);
    EXPECT_NE(said(part).find("is the first without one"), std::string::npos) << said(part);
    Samples other = good;
    other.width = 17;
    EXPECT_NE(said(other).find("17 x 16"), std::string::npos);
    Samples ahead = first.state;
    ahead.meta.find("adaptive")->set("taken", Json(5.0));
    EXPECT_NE(error_of([&] { next(ahead, good); }).find("no end of a step"), std::string::npos);
    // A state that is none, and one that was damaged.
    EXPECT_NE(error_of([&] { next(good, good); }).find("no \"adaptive\""), std::string::npos);
    Samples damaged = first.state;
    damaged.meta.find("adaptive")->set("capacity", Json(1e9));
    EXPECT_NE(error_of([&] { next(damaged, good); }).find("'capacity' is"), std::string::npos);
    EXPECT_NE(error_of([&] { RunNode("adaptive-end").in("state", first.state).out<Samples>("samples"); }).find("nothing was sampled yet"), std::string::npos);
    // What is not finite is black, and too much of it an error.
    std::vector<float> broken(good.rgb().begin(), good.rgb().end());
    broken[5] = std::numeric_limits<float>::quiet_NaN();
    Samples one = good;
    one.add("rgb", 3, broken);
    EXPECT_EQ(said(one), "");
    for (size_t i = 0; i < broken.size() / 2; ++i) broken[i] = std::numeric_limits<float>::infinity();
    one.add("rgb", 3, broken);
    EXPECT_NE(said(one).find("not finite"), std::string::npos);
}

// A document with what is needed to be a function of points.
std::string function_graph(const TestFolder& folder, const std::string& nodes, const std::string& output) {
    const std::string file = folder / "function.json";
    std::ofstream(file) << R"({"weft": 1, "about": "a function of points",
        "parameters": {)" << (nodes.find("$bound") < nodes.size() ? R"("bound": {"type": "number", "default": 0.6, "about": "of radiance"})" : "") << R"(},
        "inputs": {"points": {"type": "Samples", "about": "asked for"}},
        "outputs": {"samples": ")" << output << R"("},
        "nodes": {)" << nodes << "}}";
    return file;
}
const std::string evaluate_disc = R"("disc": {"type": "test-sampler"}, "ask": {"type": "evaluate-points", "in": {"sampler": "disc", "points": "points"}})";

TEST(GraphSampler, IsTheGraphAsAFunction) {
    const TestFolder folder;
    const std::string file = function_graph(folder, evaluate_disc + R"(, "bounded": {"type": "clamp-radiance", "in": {"samples": "ask"}, "set": {"most": "$bound"}})", "bounded");
    const auto node = [&](Json set = Json::object()) {
        return RunNode("graph-sampler").set("graph", Json(file)).set("set", std::move(set)).set("width", Json(48.0)).set("height", Json(48.0)).set("scales", numbers({28})).out<SamplerFunction>("sampler");
    };
    const SamplerFunction plain = disc(), bounded = node();
    Json high = Json::object();
    high.set("bound", Json(100.0));
    const SamplerFunction unbounded = node(high);
    const size_t n = 5000;
    std::vector<std::vector<float>> at(3, std::vector<float>(n));
    for (size_t d = 0; d < 3; ++d)
        for (size_t i = 0; i < n; ++i) at[d][i] = float((i * (2 * d + 3) * 379 + d) % 1009) / 1009;
    const std::vector<std::span<const float>> axes(at.begin(), at.end());
    std::vector<float> a(3 * n), b(3 * n), c(3 * n);
    plain.evaluate({axes}, 0, a);
    bounded.evaluate({axes}, 0, b);
    unbounded.evaluate({axes}, 0, c);
    EXPECT_EQ(a, c);
    size_t bright = 0;
    for (size_t i = 0; i < 3 * n; ++i) {
        EXPECT_LE(b[i], 0.6f + 1e-6f);
        if (a[i] < 0.59f) { EXPECT_EQ(a[i], b[i]); }
        bright += a[i] > 0.6f;
    }
    EXPECT_GT(bright, 100u);
    // And what calls it samples as it would sample the graph's own renderer.
    expect_same_bits(adaptive(plain).samples, adaptive(unbounded).samples);
}

TEST(GraphSampler, SaysWhatIsWrongWithTheGraph) {
    const TestFolder folder;
    const auto said = [&](const std::string& nodes, const std::string& output) {
        const std::string file = function_graph(folder, nodes, output);
        return error_of([&] { RunNode("graph-sampler").set("graph", Json(file)).out<SamplerFunction>("sampler"); });
    };
    EXPECT_NE(said(evaluate_disc, "asks").find("did you mean"), std::string::npos) << said(evaluate_disc, "asks");
    EXPECT_NE(said(R"("disc": {"type": "test-sampler"}, "even": {"type": "uniform-samples", "in": {"sampler": "disc"}})", "even.samples").find("does not depend on its points"), std::string::npos);
    EXPECT_NE(error_of([&] { RunNode("graph-sampler").set("graph", Json(folder / "nowhere.json")).out<SamplerFunction>("sampler"); }).find("nowhere.json"), std::string::npos);
    // What goes wrong later is said with the node's name.
    const std::string file = function_graph(folder, R"("disc": {"type": "test-sampler"}, "ask": {"type": "evaluate-points", "in": {"sampler": "disc", "points": "points"}})", "ask");
    const SamplerFunction four = RunNode("graph-sampler").set("graph", Json(file)).set("axes", words({"u", "v"})).out<SamplerFunction>("sampler");
    const std::vector<float> half{0.5f};
    const std::vector<std::span<const float>> axes(4, half);
    std::vector<float> rgb(3);
    EXPECT_NE(error_of([&] { four.evaluate({axes}, 0, rgb); }).find("evaluate-points"), std::string::npos);
}

// A renderer in a language of its own, with no library: it reads the npz by hand.
class Child {
  public:
    explicit Child(const std::string& answer) : file_(folder_ / "renderer.py") {
        std::ofstream(file_) << R"(import io, math, os, struct, sys, time, zipfile

def array(name, data):
    head, = struct.unpack('<H', data[8:10])
    text = data[10:10 + head].decode()
    shape = tuple(int(n) for n in text.split('(')[1].split(')')[0].split(',') if n.strip())
    kind = {'<f4': 'f', '<u4': 'I', '|u1': 'B'}[text.split("'descr': '")[1].split("'")[0]]
    count = 1
    for n in shape: count *= n
    return shape, struct.unpack('<%d%s' % (count, kind), data[10 + head:])

def npz(**arrays):
    out = io.BytesIO()
    with zipfile.ZipFile(out, 'w') as z:
        for name, (shape, values) in arrays.items():
            head = "{'descr': '<f4', 'fortran_order': False, 'shape': %s, }" % (shape,)
            head += ' ' * (-(len(head) + 11) % 64) + '\n'
            z.writestr(name + '.npy', b'\x93NUMPY\x01\x00' + struct.pack('<H', len(head)) + head.encode() + struct.pack('<%df' % len(values), *values))
    return out.getvalue()

def send(data):
    sys.stdout.buffer.write(struct.pack('<Q', len(data)) + data)
    sys.stdout.buffer.flush()

asked = 0
while True:
    length = sys.stdin.buffer.read(8)
    if len(length) < 8: break
    data = sys.stdin.buffer.read(struct.unpack('<Q', length)[0])
    with zipfile.ZipFile(io.BytesIO(data)) as z:
        question = {n[:-4]: array(n, z.read(n)) for n in z.namelist()}
    (n, axes), point = question['point']
    names = bytes(question['axes'][1]).decode().split()
    width, height = question['size'][1]
    asked += 1
)" << answer << "\n";
    }
    RunNode node(double timeout = 20, int processes = 1) const {
        RunNode node("process-sampler");
        node.set("command", words({"/usr/bin/python3", file_})).set("width", Json(12.0)).set("height", Json(10.0)).set("scales", numbers({6})).set("timeout", Json(timeout)).set("processes", Json(double(processes)));
        return node;
    }

  private:
    TestFolder folder_;
    std::string file_;
};
const std::string ramp = R"(
    rgb = []
    for i in range(n):
        x, y, t = point[axes * i:axes * i + 3]
        rgb += [0.25 * x + 0.5 * t, y, 0.125]
    send(npz(rgb=((n, 3), rgb), z=((n,), [2.0] * n))))";

bool have_python() { return std::ifstream("/usr/bin/python3").good(); }
#define NEEDS_PYTHON \
    if (!have_python()) GTEST_SKIP() << "no /usr/bin/python3"

TEST(ProcessSampler, AsksAChildProcess) {
    NEEDS_PYTHON;
    const Child child(ramp);
    for (const int processes : {1, 3}) {
        const SamplerFunction sampler = child.node(20, processes).set("features", words({"z"})).out<SamplerFunction>("sampler");
        ASSERT_EQ(sampler.dimensions(), 3u);
        EXPECT_EQ(sampler.axes[2].scale, 6);
        const Sampled made = adaptive(sampler, 6);
        ASSERT_EQ(made.samples.size(), 6u * 12 * 10);
        for (size_t i = 0; i < made.samples.size(); ++i) {
            EXPECT_NEAR(made.samples.rgb()[3 * i], 0.25f * made.samples.xy()[2 * i] / 12 + 0.5f * made.samples.t()[i], 1e-6f);
            EXPECT_NEAR(made.samples.rgb()[3 * i + 1], made.samples.xy()[2 * i + 1] / 10, 1e-6f);
            EXPECT_EQ(made.samples.z()[i], 2);
        }
        EXPECT_TRUE(made.warnings.empty());
    }
}

TEST(ProcessSampler, SaysHowAChildFailed) {
    NEEDS_PYTHON;
    const auto said = [](const std::string& answer, double timeout = 20) {
        const Child child(answer);
        const SamplerFunction sampler = child.node(timeout).out<SamplerFunction>("sampler");
        const std::string first = error_of([&] { adaptive(sampler); });
        // It stays broken, without waiting again.
        EXPECT_NE(error_of([&] { adaptive(sampler); }), "");
        return first;
    };
    EXPECT_NE(said("    time.sleep(60)", 0.5).find("no whole answer within 0.5 s"), std::string::npos);
    EXPECT_NE(said("    sys.stdout.buffer.write(b'12345'); sys.stdout.buffer.flush(); time.sleep(60)", 0.5).find("no whole answer within 0.5 s"), std::string::npos);
    EXPECT_NE(said("    sys.exit(7)").find("ended with status 7"), std::string::npos);
    EXPECT_NE(said("    os.kill(os.getpid(), 11)").find("ended by signal 11"), std::string::npos);
    EXPECT_NE(said("    sys.stdout.buffer.write(struct.pack('<Q', 5000) + b'short'); sys.exit(0)").find("ended with status 0 where an answer was due"), std::string::npos);
    EXPECT_NE(said("    print('rendering ...' * 10); sys.stdout.flush(); time.sleep(60)").find("nothing else may be printed"), std::string::npos);
    EXPECT_NE(said("    send(b'this is no zip file, however long it is')").find("answer of"), std::string::npos);
    EXPECT_NE(said("    send(npz(rgb=((n - 1, 3), [0.5] * (3 * n - 3))))").find("one row for each point"), std::string::npos);
    EXPECT_NE(said("    send(npz(rgb=((n, 4), [0.5] * (4 * n))))").find("one row for each point"), std::string::npos);
    EXPECT_NE(said("    send(npz(radiance=((n, 3), [0.5] * (3 * n))))").find("no array 'rgb'"), std::string::npos);
    EXPECT_NE(said("    send(npz(rgb=((n, 3), [float('nan')] * (3 * n))))").find("not finite"), std::string::npos);
    // The second answer: the first was good.
    EXPECT_NE(said(R"(
    if asked == 2: sys.exit(3)
    send(npz(rgb=((n, 3), [0.5 * (i % 7) for i in range(3 * n)]))))").find("after 1 answers"), std::string::npos);
}

TEST(ProcessSampler, SaysWhatCannotBeStarted) {
    const auto said = [](Json command) { return error_of([&] { RunNode("process-sampler").set("command", std::move(command)).out<SamplerFunction>("sampler"); }); };
    EXPECT_NE(said(words({"/nowhere/renderer"})).find("cannot start '/nowhere/renderer'"), std::string::npos);
    EXPECT_NE(said(words({})).find("no command"), std::string::npos);
    const auto shaped = [](Json axes, Json scales) { return error_of([&] { RunNode("process-sampler").set("command", words({"cat"})).set("axes", std::move(axes)).set("scales", std::move(scales)).out<SamplerFunction>("sampler"); }); };
    EXPECT_NE(shaped(words({"u", "v"}), numbers({4})).find("1 scales for 2 axes"), std::string::npos);
    EXPECT_NE(shaped(words({"t", "t"}), Json::list()).find("'t' is there twice"), std::string::npos);
}

}  // namespace
}  // namespace weft
