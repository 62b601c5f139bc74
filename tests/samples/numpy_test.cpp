// Files that numpy wrote, and numpy's view of ours.
#include <cstdio>

#include "sample_files.h"
#include "samples/write_npz.h"
#include "samples/zip_reader.h"

namespace weft::testing {
namespace {

struct Numpy : ::testing::Test {
    const TemporaryFolder folder;

    void SetUp() override {
        if (run("import numpy") != 0) GTEST_SKIP() << "no numpy under /usr/bin/python3";
    }
    int run(const std::string& script) {
        put_bytes(folder / "script.py", script);
        return std::system(
            ("cd '" + folder.path() + "' && /usr/bin/python3 script.py 2> errors").c_str());
    }
    void must_run(const std::string& script) {
        ASSERT_EQ(run(script), 0) << bytes_in(folder / "errors");
    }
};

const std::string make_buffer = R"(
import json, numpy as np
w, h, n = 5, 4, 3
N = w * h * n
rng = np.random.default_rng(1)
meta = dict(weft_samples=1, width=w, height=h, spp=n, lens=dict(coc=[-3.5, 0.25]), source="numpy",
            roles=dict(flavour="feature"))
pixel = np.arange(N) // n
xy = np.stack([pixel % w, pixel // w], 1) + rng.random((N, 2))
s = dict(meta=np.frombuffer(json.dumps(meta).encode(), np.uint8), xy=xy.astype('f4'),
         uv=(rng.random((N, 2)) - .5).astype('f2'), t=rng.random(N).astype('f8'),
         z=np.where(rng.random(N) < .2, np.inf, 1 + rng.random(N)).astype('f4'),
         rgb=rng.integers(0, 256, (N, 3)).astype('u1'), id=np.arange(N).astype('u2'),
         light_index=(np.arange(N) + 4000000000).astype('u4'), flavour=rng.random((N, 7)).astype('f4'))
)";

// The sums that the script wrote, channel by channel, against ours.
void expect_sums(const Samples& s, const std::string& sums) {
    std::istringstream in(sums);
    std::string name;
    double sum = 0;
    size_t channels = 0;
    while (in >> name >> sum) {
        const Channel* c = s.find(name);
        ASSERT_TRUE(c) << name;
        double ours = 0;
        for (const float v : c->values.view()) ours += std::isinf(v) ? 0 : double(v);
        for (const std::uint32_t v : c->ids.view()) ours += v;
        EXPECT_NEAR(ours, sum, 1e-6 * std::abs(sum)) << name;
        ++channels;
    }
    EXPECT_EQ(channels, 8u);
}
const std::string print_sums = R"(
with open('sums', 'w') as f:
    for k, v in s.items():
        if k != 'meta':
            v = v.astype('f4') if v.dtype == np.float64 else v
            v = v.astype('f8'); print(k, repr(float(v[np.isfinite(v)].sum())), file=f)
)";

TEST_F(Numpy, savez_and_savez_compressed_are_read) {
    for (const char* save : {"savez", "savez_compressed"}) {
        must_run(make_buffer + "np." + save + "('a.npz', **s)\n" + print_sums);
        const Samples s = read_file(folder / "a.npz");
        EXPECT_EQ(s.width, 5);
        EXPECT_EQ(s.size(), 60u);
        EXPECT_EQ(s.lens->c0, -3.5f);
        EXPECT_TRUE(s.find("id")->whole());
        EXPECT_EQ(s.find("light_index")->ids[59], 4000000059u);
        EXPECT_EQ(s.find("flavour")->components, 7);
        EXPECT_EQ(s.find("flavour")->role, Role::feature);
        EXPECT_GT(s.rgb()[0] + s.rgb()[1] + s.rgb()[2], 1);  // whole numbers stay what they are
        expect_sums(s, bytes_in(folder / "sums"));
    }
}

TEST_F(Numpy, its_large_zips_are_read) {
    must_run("import zipfile\nzipfile.ZIP64_LIMIT = 100\nzipfile.ZIP_FILECOUNT_LIMIT = 2\n" +
             make_buffer + "np.savez('a.npz', **s)\n" + print_sums);
    EXPECT_NE(bytes_in(folder / "a.npz").find("PK\x06\x06"), std::string::npos);
    expect_sums(read_file(folder / "a.npz"), bytes_in(folder / "sums"));
}

TEST_F(Numpy, what_it_writes_otherwise_is_refused_with_the_way_out) {
    const auto says = [&](const std::string& change) {
        must_run(make_buffer + change + "\nnp.savez('a.npz', **s)\n");
        return error_reading(folder / "a.npz");
    };
    EXPECT_SAYS(says("s['xy'] = np.asfortranarray(s['xy'])"),
                "a.npz: 'xy' is in Fortran order; save it with numpy.ascontiguousarray()");
    EXPECT_SAYS(says("s['z'] = s['z'].astype('>f4')"), "a.npz: 'z' is big-endian ('>f4')");
    EXPECT_SAYS(says("s['z'] = s['z'].astype(object)"), "a.npz: 'z' is an array of Python objects");
    EXPECT_SAYS(says("s['z'] = np.arange(N)"), "a.npz: 'z' has type '<i8'");
    EXPECT_SAYS(says("s['z'] = np.zeros(N, dtype=[('a', 'f4')])"),
                "a.npz: 'z' is an array of records");
}

TEST_F(Numpy, the_lines_in_the_documentation_make_a_file) {
    const std::string page = bytes_in(WEFT_SOURCE_DIR "/docs/formats.md");
    const std::string fence = "```python\n";
    std::string script;
    for (size_t at = 0; (at = page.find(fence, at)) != std::string::npos; at += fence.size())
        script += page.substr(at + fence.size(), page.find("```", at + 3) - at - fence.size());
    must_run(script + "assert meta['width'] == 64 and xy.shape == (64 * 36 * 4, 2)\n");
    const Samples s = read_file(folder / "mine.npz");
    EXPECT_EQ(s.width, 64);
    EXPECT_EQ(s.height, 36);
    EXPECT_EQ(s.spp, 4);
    EXPECT_FALSE(s.lens);
}

TEST_F(Numpy, it_reads_ours) {
    PlainContext ctx;
    for (const bool deflate : {false, true}) {
        write_npz(rich_buffer(), folder / "ours.npz", deflate, ctx);
        must_run(R"(
import json, zipfile, numpy as np
assert zipfile.ZipFile('ours.npz').testzip() is None
a = np.load('ours.npz')
meta = json.loads(a['meta'].tobytes())
assert meta['weft_samples'] == 1 and meta['spp'] == 2 and meta['width'] == 4, meta
assert abs(meta['lens']['coc'][0] + 35.0849527) < 1e-5
assert a['xy'].shape == (24, 2) and a['xy'].dtype == np.dtype('<f4')
assert a['z'].shape == (24,) and np.isinf(a['z'][4])
assert a['id'].dtype == np.dtype('<u4') and a['id'][1] == 0xfffffff1
assert a['five_things'][3, 2] == 1
)");
    }
}

TEST_F(Numpy, it_reads_our_sizes_of_64_bits) {
    put_npz(folder / "ours.npz",
            {member("a", 1, std::vector<float>(100, 2)), member("b", 1, {1, 2, 3})}, false, 100);
    must_run(R"(
import zipfile, numpy as np
assert zipfile.ZipFile('ours.npz').testzip() is None
a = np.load('ours.npz')
assert a['a'].sum() == 200 and list(a['b']) == [1, 2, 3]
)");
}

}  // namespace
}  // namespace weft::testing
