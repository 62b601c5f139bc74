// sheet: pictures side by side with their names below, as in a paper: input | reconstruction |
// reference | error. With a table from 'compare' each caption also has its picture's measures.
#include <fmt/format.h>

#include <algorithm>

#include "image/color_tags.h"
#include "image/draw_text.h"
#include "image/table.h"
#include "runtime/node.h"

namespace weft {
namespace {

constexpr std::array<float, 3> paper = {0.11f, 0.11f, 0.12f}, ink = {0.92f, 0.92f, 0.90f},
                               faint = {0.66f, 0.67f, 0.66f};

// Copies R G B (or a single channel as grey), enlarged by whole pixels, over `paper` where alpha is
// below 1.
void place(const Image& image, int x0, int y0, int zoom, Image& sheet) {
    int rgb[3] = {image.find("R"), image.find("G"), image.find("B")};
    const int alpha = image.find("A");
    if (rgb[0] < 0 || rgb[1] < 0 || rgb[2] < 0)
        rgb[0] = rgb[1] = rgb[2] = std::max(image.find("Y"), 0);
    for (int y = 0; y < image.height() * zoom; ++y)
        for (int x = 0; x < image.width() * zoom; ++x) {
            const float* from = image.at(x / zoom, y / zoom);
            float* to = sheet.at(x0 + x, y0 + y);
            const float through = alpha >= 0 ? 1 - from[alpha] : 0.0f;
            for (size_t c = 0; c < 3; ++c) to[c] = from[rgb[c]] + through * paper[c];
        }
}

// "relmse 0.0123  flip 0.045" of the row whose first cell is `name`; "" where there is none.
std::string measures_of(const Table& table, const std::string& name,
                        const std::vector<std::string>& columns) {
    for (size_t r = 0; r < table.rows.size(); ++r) {
        const auto* word =
            table.rows[r].empty() ? nullptr : std::get_if<std::string>(&table.rows[r][0]);
        if (!word || *word != name) continue;
        std::string text;
        for (const std::string& column : columns) {
            const Table::Cell* cell = table.find(r, column);
            const double* number = cell ? std::get_if<double>(cell) : nullptr;
            if (number)
                text += fmt::format("{}{} {:.4g}", text.empty() ? "" : "  ", column, *number);
        }
        return text;
    }
    return {};
}

struct Sheet {
    std::vector<std::string> labels;
    std::vector<std::string> measures = {"relmse", "flip"};
    int columns = 0, gap = 8, zoom = 1, text_size = 2;
    std::string title;

    static void declare(Ports<Sheet>& node) {
        node.about("pictures side by side with captions")
            .in<Image>("image", "display pictures, in order", Need::variadic)
            .in<Table>("table", "measures by picture, from 'compare'", Need::optional)
            .out<Image>("image", "the sheet, R G B, in the space of the first picture")
            .param("labels", &Sheet::labels,
                   {.about = "captions in order; the nodes' names where there are none"})
            .param("measures", &Sheet::measures,
                   {.about = "columns of the table that go below a caption"})
            .param("columns", &Sheet::columns,
                   {.min = 0, .max = 100, .about = "pictures in a row; 0: all"})
            .param("gap", &Sheet::gap,
                   {.unit = "px", .min = 0, .max = 1000, .about = "between pictures and around"})
            .param("zoom", &Sheet::zoom,
                   {.min = 1, .max = 16, .about = "pixels of the sheet a pixel of a picture"})
            .param("text-size", &Sheet::text_size,
                   {.unit = "px", .min = 0, .max = 16, .about = "of a dot of the letters; 0: none"})
            .param("title", &Sheet::title, {.about = "above it all"});
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const std::vector<const Image*> images = in.all<Image>("image");
        const std::vector<std::string>& names = in.names("image");
        if (images.empty()) ctx.fail("no pictures for a sheet");
        bool linear = false, display = false;
        int cell_width = 0, cell_height = 0;
        for (const Image* image : images) {
            (is_scene_linear(image->color_space) ? linear : display) = true;
            if (image->find("R") < 0 && image->find("Y") < 0 && image->channels() != 1)
                ctx.fail(fmt::format("a picture with channels {} has no colours to show",
                                     fmt::join(image->names(), " ")));
            cell_width = std::max(cell_width, image->width() * zoom);
            cell_height = std::max(cell_height, image->height() * zoom);
        }
        if (linear && display)
            ctx.fail(
                "scene-linear and display pictures on one sheet; put 'ocio-display' before the "
                "linear ones");

        const Table* table = in.find<Table>("table");
        const int line = text_size * (letter_height + 2);
        std::vector<std::string> captions, notes;
        for (size_t i = 0; i < images.size(); ++i) {
            const std::string name = i < names.size() ? names[i] : fmt::format("{}", i + 1);
            captions.push_back(i < labels.size() ? labels[i] : name);
            notes.push_back(table ? measures_of(*table, name, measures) : std::string());
            if (table && notes.back().empty())
                notes.back() = measures_of(*table, captions.back(), measures);
        }
        const bool noted = std::any_of(notes.begin(), notes.end(),
                                       [](const std::string& n) { return !n.empty(); });
        const int caption = text_size == 0 ? 0 : line * (noted ? 2 : 1) + text_size;
        const int across = columns > 0 ? std::min(columns, int(images.size())) : int(images.size());
        const int down = (int(images.size()) + across - 1) / across;
        const int head = title.empty() || text_size == 0 ? 0 : line + gap;
        Image sheet(gap + across * (cell_width + gap),
                    head + gap + down * (cell_height + caption + gap), 3);
        sheet.color_space = images.front()->color_space;
        sheet.display = images.front()->display;
        sheet.view = images.front()->view;
        for (const Image* image : images)  // which colour config made them
            if (const auto config = image->attributes.find("weft:ocio");
                config != image->attributes.end())
                sheet.attributes.insert(*config);
        for (size_t i = 0; i < sheet.pixels().size(); ++i) sheet.pixels()[i] = paper[i % 3];
        if (head > 0) draw_text(sheet, gap, gap, title, text_size, ink);
        for (size_t i = 0; i < images.size(); ++i) {
            const int x = gap + int(i) % across * (cell_width + gap);
            const int y = head + gap + int(i) / across * (cell_height + caption + gap);
            place(*images[i], x, y, zoom, sheet);
            if (text_size == 0) continue;
            draw_fitting(sheet, x, y + cell_height + 2 * text_size, captions[i], cell_width, ink);
            draw_fitting(sheet, x, y + cell_height + 2 * text_size + line, notes[i], cell_width,
                         faint);
        }
        out.set("image", std::move(sheet));
    }

    // Smaller letters where a caption is wider than its picture.
    void draw_fitting(Image& sheet, int x, int y, const std::string& text, int width,
                      const std::array<float, 3>& color) const {
        int size = text_size;
        while (size > 1 && text_width(text, size) > width) --size;
        const size_t most = size_t(std::max(1, (width / size + 1) / letter_width));
        draw_text(sheet, x, y, std::string_view(text).substr(0, most), size, color);
    }
};

WEFT_NODE(Sheet, "sheet", 1);

}  // namespace
}  // namespace weft
