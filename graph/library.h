// Library: the documents a graph is made of, each file read once.
#pragma once
#include <map>
#include <string>

#include "graph/table.h"

namespace weft::loading {

class Library {
  public:
    Library(NodeTable& table, Findings& findings) : table_(table), findings_(findings) {}

    // nullptr: it cannot be read; `problem` says why. A document with errors is returned all the
    // same.
    const Document* file(const std::string& path, std::string& problem);
    const Document& text(std::string text, const std::string& name);

  private:
    const Document& add(std::string text, const std::string& name, const std::string& canonical);
    NodeTable& table_;
    Findings& findings_;
    std::map<std::string, const Document*> read_;  // by canonical path
};

// A whole small file; false with the reason if it cannot be read.
bool read_text_file(const std::string& path, std::string& text, std::string& problem);

}  // namespace weft::loading
