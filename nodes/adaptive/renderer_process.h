// A renderer as a child process. It reads questions from its standard input and writes answers to
// its standard output, one after another, until its input ends:
//   a message   8 bytes, its length, least byte first; then as many bytes of an .npz file
//   question    point (N x axes, f4 in [0, 1]), axes (their names, one a line, u1), size (width,
//               height, u4), seed (u4: of what the axes leave open)
//   answer      rgb (N x 3), and an array for each feature, N rows each
// What it writes to its standard error is the user's to see.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace weft::adaptive {

class RendererProcess {
  public:
    // `timeout_s`: for one question and its answer. Throws Error where it cannot be started.
    RendererProcess(std::vector<std::string> command, double timeout_s);
    ~RendererProcess();  // its input ends; if it does not go within a second, it is killed
    RendererProcess(const RendererProcess&) = delete;
    RendererProcess& operator=(const RendererProcess&) = delete;

    // The bytes of the answer. Throws Error, naming command and what happened: it ended (with which
    // status, or by which signal), it was silent for too long, or said a length that cannot be.
    // After that it has been killed, and asking again says the same.
    std::vector<std::uint8_t> ask(std::span<const std::uint8_t> question, size_t most_bytes);

  private:
    void wait_for(short event, double deadline);
    void write_all(std::span<const std::uint8_t> bytes, double deadline);
    void read_all(std::span<std::uint8_t> bytes, double deadline);
    [[noreturn]] void fail(const std::string& what);
    [[noreturn]] void fail_at_end();
    void kill_it();

    std::vector<std::string> command_;
    double timeout_s_;
    pid_t pid_ = -1;
    int socket_ = -1;
    size_t answered_ = 0;
    std::string broken_;  // why it can no longer be asked
    std::mutex one_at_a_time_;
};

}  // namespace weft::adaptive
