#include "adaptive/renderer_process.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "graph/error.h"

extern char** environ;

namespace weft::adaptive {
namespace {

double now_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

// Whether it has ended, waiting for `seconds` at most.
bool ends_within(pid_t pid, double seconds, int& status) {
    const double until = now_s() + seconds;
    while (true) {
        const pid_t ended = ::waitpid(pid, &status, WNOHANG);
        if (ended == pid || (ended < 0 && errno != EINTR)) return true;
        if (now_s() > until) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

}  // namespace

RendererProcess::RendererProcess(std::vector<std::string> command, double timeout_s)
    : command_(std::move(command)), timeout_s_(timeout_s) {
    if (command_.empty() || command_[0].empty())
        throw Error("no command; say which program renders: [\"python3\", \"renderer.py\"]");
    // A socket, not pipes: writing to a child that has gone is then an error and not a signal.
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
        throw Error(
            fmt::format("cannot start '{}': {}", fmt::join(command_, " "), std::strerror(errno)));
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    // What this program does with signals is not the child's affair; Ctrl-C is this one's alone.
    sigset_t usual;
    sigemptyset(&usual);
    for (const int signal : {SIGINT, SIGTERM, SIGPIPE}) sigaddset(&usual, signal);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    std::vector<char*> argv;
    for (std::string& argument : command_) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const int failed = ::posix_spawnp(&pid_, argv[0], &actions, &attributes, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    ::close(ends[1]);
    socket_ = ends[0];
    if (failed != 0) {
        ::close(socket_);
        pid_ = -1;
        throw Error(fmt::format("cannot start '{}': {}; is it on PATH, or give its whole path",
                                fmt::join(command_, " "), std::strerror(failed)));
    }
}

RendererProcess::~RendererProcess() {
    if (socket_ >= 0) ::close(socket_);
    int status = 0;
    if (pid_ > 0 && !ends_within(pid_, 1.0, status)) kill_it();
}

void RendererProcess::kill_it() {
    if (pid_ <= 0) return;
    ::kill(-pid_, SIGKILL);  // and what it started itself
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
}

void RendererProcess::fail(const std::string& what) {
    broken_ = fmt::format("'{}' {} (after {} answers)", fmt::join(command_, " "), what, answered_);
    kill_it();
    throw Error(broken_);
}

// Its end of the socket is closed: it has ended, or will soon.
void RendererProcess::fail_at_end() {
    int status = 0;
    if (!ends_within(pid_, 1.0, status))
        fail("closed its output; a renderer answers until its input ends");
    ::kill(-pid_, SIGKILL);
    pid_ = -1;
    if (WIFSIGNALED(status))
        fail(fmt::format("was ended by signal {} ({}); run it by hand on one question",
                         WTERMSIG(status), strsignal(WTERMSIG(status))));
    fail(
        fmt::format("ended with status {} where an answer was due; see what it wrote to its "
                    "standard error",
                    WEXITSTATUS(status)));
}

void RendererProcess::wait_for(short event, double deadline) {
    while (true) {
        pollfd wait{socket_, event, 0};
        const double left = deadline - now_s();
        const int ready = left > 0 ? ::poll(&wait, 1, int(left * 1000) + 1) : 0;
        if (ready > 0) return;
        if (ready == 0)
            fail(fmt::format("{} within {} s; raise timeout, or see whether it hangs",
                             event == POLLOUT ? "did not read a question" : "gave no whole answer",
                             timeout_s_));
        if (errno != EINTR) fail(fmt::format("cannot be waited for: {}", std::strerror(errno)));
    }
}

void RendererProcess::write_all(std::span<const std::uint8_t> bytes, double deadline) {
    while (!bytes.empty()) {
        wait_for(POLLOUT, deadline);
        const ssize_t sent =
            ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent >= 0)
            bytes = bytes.subspan(size_t(sent));
        else if (errno != EINTR && errno != EAGAIN)
            fail_at_end();
    }
}

void RendererProcess::read_all(std::span<std::uint8_t> bytes, double deadline) {
    while (!bytes.empty()) {
        wait_for(POLLIN, deadline);
        const ssize_t got = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (got > 0)
            bytes = bytes.subspan(size_t(got));
        else if (got == 0 || (errno != EINTR && errno != EAGAIN))
            fail_at_end();
    }
}

std::vector<std::uint8_t> RendererProcess::ask(std::span<const std::uint8_t> question,
                                               size_t most_bytes) {
    const std::lock_guard lock(one_at_a_time_);
    if (!broken_.empty()) throw Error(broken_);
    const double deadline = now_s() + timeout_s_;
    std::array<std::uint8_t, 8> length{};
    for (size_t i = 0; i < 8; ++i)
        length[i] = std::uint8_t(std::uint64_t(question.size()) >> (8 * i));
    write_all(length, deadline);
    write_all(question, deadline);
    read_all(length, deadline);
    std::uint64_t size = 0;
    for (size_t i = 0; i < 8; ++i) size |= std::uint64_t(length[i]) << (8 * i);
    if (size > most_bytes)
        fail(
            fmt::format("says its answer has {} bytes, where at most {} can be meant; an answer "
                        "begins with its length as 8 bytes, least first, and nothing else may "
                        "be printed",
                        size, most_bytes));
    std::vector<std::uint8_t> answer(size);
    read_all(answer, deadline);
    ++answered_;
    return answer;
}

}  // namespace weft::adaptive
