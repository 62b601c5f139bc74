// Pictures by name: formats, folders, what is said of bad ones, no half files, the module.
#include "image/picture_file.h"

#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "image/other_formats.h"
#include "run_node.h"

namespace weft {
namespace {

std::vector<std::string> warnings;

Image ramp(int width = 64, int height = 48) {
    Image image(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            image.at(x, y)[0] = float(x) / float(width - 1);
            image.at(x, y)[1] = float(y) / float(height - 1);
            image.at(x, y)[2] = 0.5f;
        }
    image.color_space = image.display = "sRGB";
    return image;
}

size_t files_in(const std::string& folder) {
    size_t count = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        count += entry.is_regular_file();
    return count;
}

void put(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

TEST(PictureFile, MakesMissingFolders) {
    TestFolder folder;
    write_picture(folder / "a/b/c.exr", ramp(), {}, warnings);
    EXPECT_EQ(read_picture(folder / "a/b/c.exr").width(), 64);
    EXPECT_EQ(files_in(folder.path()), 1u);  // nothing temporary is left
}

TEST(PictureFile, IsToldApartByContentNotName) {
    TestFolder folder;
    write_picture(folder / "a.exr", ramp(), {}, warnings);
    std::filesystem::rename(folder / "a.exr", folder / "a.png");
    EXPECT_EQ(picture_info(folder / "a.png").format, "EXR");
    EXPECT_EQ(read_picture(folder / "a.png").height(), 48);
}

TEST(PictureFile, PfmIsExact) {
    TestFolder folder;
    Image image = ramp(7, 5);
    image.at(3, 2)[1] = -1e-40f;
    write_picture(folder / "a.pfm", image, {}, warnings);
    const Image back = read_picture(folder / "a.pfm");
    EXPECT_TRUE(std::equal(image.pixels().begin(), image.pixels().end(), back.pixels().begin()));
    put(folder / "big.pfm", std::string("Pf\n1 1\n1.0\n") + std::string("\x3f\x80\x00\x00", 4));
    EXPECT_EQ(read_picture(folder / "big.pfm").pixels()[0], 1.0f);
    put(folder / "short.pfm", "PF\n4 4\n-1.0\nabc");
    EXPECT_NE(error_of([&] { read_picture(folder / "short.pfm"); }).find("short.pfm"),
              std::string::npos);
}

TEST(PictureFile, SaysWhatIsWrongWithAFile) {
    TestFolder folder;
    put(folder / "empty.exr", "");
    put(folder / "words.exr", "this is no picture\n");
    put(folder / "head.exr", std::string("\x76\x2f\x31\x01\x02\0\0\0", 8));
    for (const char* name : {"missing.exr", "empty.exr", "words.exr", "head.exr"}) {
        const std::string message = error_of([&] { read_picture(folder / name); });
        EXPECT_NE(message.find(name), std::string::npos) << message;
        EXPECT_NE(error_of([&] { picture_info(folder / name); }).find(name), std::string::npos);
    }
    EXPECT_NE(error_of([&] { read_picture(folder / "missing.exr"); }).find("No such file"),
              std::string::npos);
    EXPECT_NE(error_of([&] { read_picture(folder.path()); }).find("directory"), std::string::npos);
}

TEST(PictureFile, ListsWhatCanBeWritten) {
    const std::string message = error_of([&] { write_picture("a.xyz", ramp(), {}, warnings); });
    for (const char* part : {"a.xyz", "'.xyz'", "exr", "png", "tif", "jpg", "pfm"})
        EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_FALSE(std::filesystem::exists("a.xyz"));
}

TEST(PictureFile, AFullDiskLeavesNothing) {
    TestFolder folder;
    write_picture(folder / "kept.exr", ramp(), {}, warnings);
    const std::string before = read_whole_file(folder / "kept.exr");
    rlimit old = {};
    getrlimit(RLIMIT_FSIZE, &old);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);  // a write past the limit fails instead
    const rlimit tiny = {100, old.rlim_max};
    setrlimit(RLIMIT_FSIZE, &tiny);
    std::vector<std::string> messages;
    for (const char* name : {"kept.exr", "new.exr", "new.png", "new.tif", "new.jpg", "new.pfm"})
        messages.push_back(error_of([&] { write_picture(folder / name, ramp(), {}, warnings); }));
    setrlimit(RLIMIT_FSIZE, &old);
    std::signal(SIGXFSZ, handler);
    for (const std::string& message : messages)
        EXPECT_NE(message.find(folder.path()), std::string::npos) << message;
    EXPECT_EQ(files_in(folder.path()), 1u);
    EXPECT_EQ(read_whole_file(folder / "kept.exr"), before);
}

TEST(PictureFile, WarnsOfLinearValuesInADisplayFormat) {
    TestFolder folder;
    Image image = ramp();
    image.color_space = "lin_rec709";
    image.display.clear();
    RunNode("write-image").set("file", folder / "a.exr").in("image", image).run();
    RunNode node("write-image");
    node.set("file", folder / "a.png").in("image", image).run();
    ASSERT_EQ(node.ctx.warnings.size(), 1u);
    EXPECT_NE(node.ctx.warnings[0].find("ocio-display"), std::string::npos);
}

TEST(PictureFile, ModuleWritesEveryFormatItNames) {
    TestFolder folder;
    const Image image = ramp();
    for (const std::string& extension : other_extensions()) {
        const std::string path = folder / ("a." + extension);
        write_picture(path, image, {}, warnings);
        const std::string once = read_whole_file(path);
        write_picture(path, image, {}, warnings);
        EXPECT_EQ(once, read_whole_file(path)) << extension;
        const Image back = read_picture(path);
        ASSERT_EQ(back.channels(), 3) << extension;
        double worst = 0;
        for (size_t i = 0; i < image.pixels().size(); ++i)
            worst = std::max(worst, std::abs(double(image.pixels()[i]) - back.pixels()[i]));
        EXPECT_LT(worst, 0.05) << extension;
        EXPECT_EQ(picture_info(path).width, 64);
        put(path, once.substr(0, once.size() / 2));
        EXPECT_NE(error_of([&] { read_picture(path); }).find("a." + extension), std::string::npos)
            << extension;
    }
}

// Loading OpenImageIO takes longer than most graphs: it must come with the module only.
TEST(PictureFile, TheProgramDoesNotLinkOpenImageIO) {
    const std::string command = std::string("ldd ") + WEFT_BINARY_DIR + "/weft";
    FILE* pipe = popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::string text;
    char piece[256];
    while (std::fgets(piece, sizeof piece, pipe)) text += piece;
    pclose(pipe);
    ASSERT_NE(text.find("libOpenEXR"), std::string::npos) << text;
    EXPECT_EQ(text.find("OpenImageIO"), std::string::npos) << text;
}

TEST(PictureFile, TiffKeepsFloatsAndItsColourSpace) {
    TestFolder folder;
    Image image = ramp();
    image.color_space = "lin_rec709";
    image.display.clear();
    write_picture(folder / "a.tif", image, {}, warnings);
    const Image back = read_picture(folder / "a.tif");
    EXPECT_EQ(back.color_space, "lin_rec709");
    EXPECT_TRUE(std::equal(image.pixels().begin(), image.pixels().end(), back.pixels().begin()));
    write_picture(folder / "b.tif", ramp(), {}, warnings);
    EXPECT_EQ(read_picture(folder / "b.tif").color_space, "sRGB - Texture");
    EXPECT_EQ(picture_info(folder / "b.tif").depth, "8 bit");
}

TEST(PictureFile, ReadImageTakesItsColourSpaceFromTheParameter) {
    TestFolder folder;
    write_picture(folder / "a.png", ramp(), {}, warnings);
    RunNode node("read-image");
    node.set("file", folder / "a.png");
    EXPECT_EQ(node.out<Image>("image").color_space, "sRGB");
    node.set("color-space", "ACEScct");
    EXPECT_EQ(node.out<Image>("image").color_space, "ACEScct");
}

}  // namespace
}  // namespace weft
