#include "graph/overrides.h"

namespace weft::loading {
namespace {

SourcePtr option_source(std::string_view option, const std::string& text) {
    std::string whole = fmt::format("{} {}", option, text);
    return std::make_shared<const Source>(Source{whole, whole});
}

// "name=value" from `begin` on; false if there is no '=' or no name.
bool take_setting(const SourcePtr& source, size_t begin, size_t end, SetOption& out) {
    const std::string& text = source->text;
    const size_t equals = text.find('=', begin);
    if (equals == std::string::npos || equals >= end || equals == begin) return false;
    const auto place = [&](size_t a, size_t b) {
        return Place{source, std::uint32_t(a), std::uint32_t(b)};
    };
    out.name = {text.substr(begin, equals - begin), place(begin, equals)};
    out.value = {text.substr(equals + 1, end - equals - 1), place(equals + 1, end)};
    out.place = place(0, text.size());
    return true;
}

// The end of an item of a list with commas: one within brackets or quotes does not count.
size_t item_end(std::string_view text, size_t begin) {
    int depth = 0;
    bool quoted = false;
    for (size_t i = begin; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                quoted = false;
        } else if (c == '"') {
            quoted = true;
        } else if (c == '[' || c == '{') {
            ++depth;
        } else if (c == ']' || c == '}') {
            --depth;
        } else if (c == ',' && depth <= 0) {
            return i;
        }
    }
    return text.size();
}

void take_set(const std::string& text, Options& options, Findings& findings) {
    const SourcePtr source = option_source("--set", text);
    findings.add_source(source);
    const size_t begin = source->text.size() - text.size();
    SetOption option;
    if (!take_setting(source, begin, source->text.size(), option)) {
        findings.error({source, 0, std::uint32_t(source->text.size())},
                       "expected NAME=VALUE or NODE.PARAMETER=VALUE");
        return;
    }
    if (const size_t dot = option.name.text.find('.'); dot != std::string::npos) {
        option.node = option.name.text.substr(0, dot);
        option.name.text.erase(0, dot + 1);
    }
    options.set.push_back(std::move(option));
}

void take_swap(const std::string& text, Options& options, Findings& findings) {
    const SourcePtr source = option_source("--swap", text);
    findings.add_source(source);
    const std::string& whole = source->text;
    const Place place{source, 0, std::uint32_t(whole.size())};
    const size_t begin = whole.size() - text.size();
    const size_t equals = whole.find('=', begin);
    size_t end = equals == std::string::npos ? equals : item_end(whole, equals + 1);
    if (equals == std::string::npos || equals == begin || end == equals + 1) {
        findings.error(place, "expected NODE=TYPE or NODE=TYPE,PARAMETER=VALUE");
        return;
    }
    SwapOption option;
    option.node = whole.substr(begin, equals - begin);
    option.type = {whole.substr(equals + 1, end - equals - 1), place};
    option.pin = take_pin(option.type.text);
    option.place = place;
    if (option.pin < 0) {
        findings.error(place, "'{}' pins no version; expected a number after '@'",
                       whole.substr(equals + 1, end - equals - 1));
        option.pin = 0;
    }
    while (end < whole.size()) {
        const size_t item = end + 1;
        end = item_end(whole, item);
        SetOption setting;
        if (take_setting(source, item, end, setting))
            option.settings.push_back(std::move(setting));
        else
            findings.error(place, "'{}' sets nothing; expected PARAMETER=VALUE",
                           whole.substr(item, end - item));
    }
    options.swap.push_back(std::move(option));
}

template <class List>
auto last_of(List& list, std::string_view node) {
    const typename List::value_type* found = nullptr;
    for (auto& option : list)
        if (option.node == node) {
            option.used = true;
            found = &option;
        }
    return found;
}

}  // namespace

const SwapOption* Options::swap_of(std::string_view node) {
    return last_of(swap, node);
}
const BypassOption* Options::bypass_of(std::string_view node) {
    return last_of(bypass, node);
}

const SetOption* Options::set_of(std::string_view node, std::string_view name) {
    const SetOption* found = nullptr;
    for (SetOption& option : set)
        if (option.node == node && option.name.text == name) {
            option.used = true;
            found = &option;
        }
    return found;
}

Options take_options(const Overrides& overrides, Findings& findings) {
    Options options;
    for (const std::string& text : overrides.swap) take_swap(text, options, findings);
    for (const std::string& text : overrides.bypass) {
        const SourcePtr source = option_source("--bypass", text);
        findings.add_source(source);
        options.bypass.push_back({text, {source, 0, std::uint32_t(source->text.size())}});
    }
    for (const std::string& text : overrides.set) take_set(text, options, findings);
    return options;
}

Json option_value(const Word& value, Kind kind) {
    const bool textual = kind == Kind::text || kind == Kind::file || kind == Kind::choice;
    std::vector<Diagnostic> problems;
    const auto source = std::make_shared<const Source>(Source{"", value.text});
    Json json = parse_json(source, problems);
    if (!problems.empty() || (textual && !json.is(Json::Kind::text))) json = Json(value.text);
    json.place = value.place;
    return json;
}

}  // namespace weft::loading
