#include "samples/sample_bytes.h"

#include <limits>

namespace weft {
namespace {

template <class T>
void append(std::vector<T>& to, const Array<T>& from) {
    to.insert(to.end(), from.view().begin(), from.view().end());
}

[[noreturn]] void other() {
    throw Error("holds samples that do not go with those of the first piece");
}

}  // namespace

void put_samples(ByteWriter& to, const Samples& band) {
    to.put(std::int32_t(band.width));
    to.put(std::int32_t(band.height));
    to.put(std::int32_t(band.spp));
    to.put(std::uint64_t(band.size()));
    to.put_text(band.color_space);
    to.put_text(band.domain);
    to.put(std::uint8_t(band.lens.has_value()));
    to.put(band.lens.value_or(Lens()));
    to.put_text(band.meta.dump());
    to.put_all(band.first.view());
    to.put(std::uint32_t(band.channels.size()));
    for (const Channel& channel : band.channels) {
        to.put_text(channel.name);
        to.put(std::int32_t(channel.components));
        to.put(channel.role);
        to.put_all(channel.values.view());
        to.put_all(channel.ids.view());
    }
}

Samples take_samples(ByteReader& from) {
    Samples band;
    band.width = from.take<std::int32_t>();
    band.height = from.take<std::int32_t>();
    band.spp = from.take<std::int32_t>();
    const auto size = from.take<std::uint64_t>();
    band.color_space = from.take_text();
    band.domain = from.take_text();
    const bool lens = from.take<std::uint8_t>() != 0;
    band.lens = from.take<Lens>();
    if (!lens) band.lens.reset();
    band.meta = parse_json_or_throw(from.take_text(), "meta of samples");
    band.first = from.take_all<std::uint64_t>();
    if (band.width < 0 || band.height < 0 || band.spp < 0) throw Error("holds samples of no size");
    const size_t pixels = band.pixels();
    bool fits = band.spp > 0 ? band.first.empty() && size % size_t(band.spp) == 0 &&
                                   size / size_t(band.spp) == pixels
                             : band.first.size() == pixels + 1 && band.first[0] == 0 &&
                                   band.first[pixels] == size;
    for (size_t i = 0; fits && i + 1 < band.first.size(); ++i)
        fits = band.first[i] <= band.first[i + 1];
    if (!fits) throw Error("holds samples whose number does not fit their pixels");
    band.set_size(size);
    for (auto left = from.take<std::uint32_t>(); left > 0; --left) {
        Channel channel;
        channel.name = from.take_text();
        channel.components = from.take<std::int32_t>();
        const auto role = from.take<std::underlying_type_t<Role>>();
        channel.values = from.take_all<float>();
        channel.ids = from.take_all<std::uint32_t>();
        const size_t held = channel.values.size() + channel.ids.size();
        if (role < 0 || role > int(Role::radiance) || channel.components < 1 ||
            (!channel.values.empty() && !channel.ids.empty()) ||
            held % size_t(channel.components) != 0 || held / size_t(channel.components) != size)
            throw Error("holds a channel of samples of another length");
        channel.role = Role(role);
        band.channels.push_back(std::move(channel));
    }
    return band;
}

Samples join_samples(const Pieces& pieces) {
    Samples whole;
    std::vector<std::uint64_t> first;
    std::vector<std::vector<float>> values;
    std::vector<std::vector<std::uint32_t>> ids;
    size_t size = 0;
    for (size_t i = 0; i < pieces.size(); ++i) {
        ByteReader from = pieces.read(i);
        Samples band = take_samples(from);
        if (i == 0) {
            whole = band;
            whole.height = 0;
            values.resize(band.channels.size());
            ids.resize(band.channels.size());
            for (size_t c = 0; c < band.channels.size();
                 ++c) {  // bands are alike, but for the last
                values[c].reserve(band.channels[c].values.size() * pieces.size());
                ids[c].reserve(band.channels[c].ids.size() * pieces.size());
            }
        }
        if (band.width != whole.width || band.spp != whole.spp ||
            band.channels.size() != whole.channels.size() ||
            band.height > std::numeric_limits<int>::max() - whole.height ||
            band.color_space != whole.color_space || band.domain != whole.domain ||
            !(band.lens == whole.lens))
            other();
        for (size_t c = 0; c < band.channels.size(); ++c) {
            const Channel& channel = band.channels[c];
            const Channel& like = whole.channels[c];
            if (channel.name != like.name || channel.components != like.components ||
                channel.role != like.role)
                other();
            append(values[c], channel.values);
            append(ids[c], channel.ids);
        }
        for (size_t p = 0; p + 1 < band.first.size(); ++p) first.push_back(size + band.first[p]);
        whole.height += band.height;
        size += band.size();
    }
    if (whole.spp == 0 && whole.pixels() > 0) {
        first.push_back(size);
        whole.first = std::move(first);
    }
    whole.set_size(size);
    for (size_t c = 0; c < whole.channels.size(); ++c) {
        whole.channels[c].values = std::move(values[c]);
        whole.channels[c].ids = std::move(ids[c]);
    }
    whole.meta = whole.meta_object();
    return whole;
}

}  // namespace weft
