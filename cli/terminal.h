// What goes to the terminal: results to stdout, everything else to stderr; colour only where a person
// looks on (and NO_COLOR is not set).
#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "graph/diagnostic.h"
#include "runtime/monitor.h"

namespace weft::cli {

bool stderr_is_terminal();
bool use_color();

void print(const std::string& text);           // stdout
void complain(const std::string& message);     // stderr: "weft: message"
void print_findings(const std::vector<Diagnostic>& findings);  // stderr

// Shows how far a run is until it goes out of scope: bars on a terminal, else plain lines every few
// seconds.
class ProgressDisplay {
  public:
    ProgressDisplay(Monitor& monitor, bool quiet);
    ~ProgressDisplay();
    // A line above the bars.
    void note(const std::string& line);

  private:
    void draw_bars();
    void print_lines();
    void erase_bars();

    Monitor& monitor_;
    bool terminal_;
    int drawn_ = 0;  // lines of bars on the screen
    std::mutex mutex_;
    std::condition_variable wake_;
    bool end_ = false;
    std::thread thread_;
};

// Ctrl-C and SIGTERM set this; a second one ends the process at once.
const std::atomic<bool>& interruption();
void catch_interruptions();

}  // namespace weft::cli
