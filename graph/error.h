// Error: what a function below the graph throws when the user's data cannot be used.
// The message says what is wrong, where (file, channel, pixel), what was expected and what to do;
// the runtime adds the node's name and its place in the document.
#pragma once
#include <stdexcept>
#include <string>

namespace weft {

class Error : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

// Work stopped because somebody asked for it (Ctrl-C, a failed neighbour): not a failure of its
// own.
class Cancelled : public std::exception {
  public:
    const char* what() const noexcept override { return "cancelled"; }
};

}  // namespace weft
