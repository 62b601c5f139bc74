// Findings: what is wrong with a document, gathered by the passes that read and check it.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "graph/diagnostic.h"

namespace weft::loading {

class Findings {
  public:
    template <class... Args>
    void error(const Place& place, fmt::format_string<Args...> text, Args&&... args) {
        list_.push_back(
            {Diagnostic::Level::error, fmt::format(text, std::forward<Args>(args)...), place});
    }
    template <class... Args>
    void warning(const Place& place, fmt::format_string<Args...> text, Args&&... args) {
        list_.push_back(
            {Diagnostic::Level::warning, fmt::format(text, std::forward<Args>(args)...), place});
    }
    std::vector<Diagnostic>& list() { return list_; }
    bool has_errors() const { return weft::has_errors(list_); }

    // Sources are told in the order in which they are first read.
    void add_source(const SourcePtr& source) { sources_.push_back(source.get()); }

    // By source and place, each once: a sub-graph used twice tells its errors once.
    std::vector<Diagnostic> sorted() const {
        const auto rank = [&](const Diagnostic& d) {
            if (!d.place.source) return std::ptrdiff_t(-1);
            return std::find(sources_.begin(), sources_.end(), d.place.source.get()) -
                   sources_.begin();
        };
        std::vector<std::pair<std::ptrdiff_t, Diagnostic>> ranked;
        for (const Diagnostic& d : list_) ranked.emplace_back(rank(d), d);
        std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
            return std::pair(a.first, a.second.place.begin) <
                   std::pair(b.first, b.second.place.begin);
        });
        std::vector<Diagnostic> out;
        for (auto& [r, d] : ranked) {
            bool told = false;
            for (auto o = out.rbegin(); o != out.rend() && o->place.begin == d.place.begin; ++o)
                told = told || (o->place.source == d.place.source && o->message == d.message);
            if (!told) out.push_back(std::move(d));
        }
        return out;
    }

  private:
    std::vector<Diagnostic> list_;
    std::vector<const Source*> sources_;
};

}  // namespace weft::loading
