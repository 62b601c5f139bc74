#include "cli/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "graph/error.h"

namespace weft::cli {
namespace {

int status_of(int wait_status) {
    if (WIFEXITED(wait_status)) return WEXITSTATUS(wait_status);
    return 128 + (WIFSIGNALED(wait_status) ? WTERMSIG(wait_status) : 0);
}

std::vector<char*> pointers(const std::vector<std::string>& arguments) {
    std::vector<char*> all;
    for (const std::string& argument : arguments)
        all.push_back(const_cast<char*>(argument.c_str()));
    all.push_back(nullptr);
    return all;
}

[[noreturn]] void become(const std::vector<char*>& argv) {
    // What this program does with signals is not the child's affair.
    for (const int signal : {SIGINT, SIGTERM, SIGPIPE}) std::signal(signal, SIG_DFL);
    ::execvp(argv[0], argv.data());
    _exit(127);
}

[[noreturn]] void cannot_start(const std::string& program) {
    throw Error(fmt::format("cannot start {}: {}", program, std::strerror(errno)));
}

}  // namespace

ProcessResult run_process(const std::vector<std::string>& arguments) {
    std::array<std::array<int, 2>, 2> pipes{};
    for (auto& ends : pipes)
        if (::pipe2(ends.data(), O_CLOEXEC) != 0) cannot_start(arguments[0]);
    const std::vector<char*> argv = pointers(arguments);
    const pid_t pid = ::fork();
    if (pid < 0) cannot_start(arguments[0]);
    if (pid == 0) {
        ::setpgid(0, 0);  // Ctrl-C is for this program alone
        const int none = ::open("/dev/null", O_RDONLY);
        ::dup2(none, STDIN_FILENO);
        ::dup2(pipes[0][1], STDOUT_FILENO);
        ::dup2(pipes[1][1], STDERR_FILENO);
        become(argv);
    }
    for (auto& ends : pipes) ::close(ends[1]);
    ProcessResult result;
    std::array<std::string*, 2> texts = {&result.out, &result.err};
    std::array<bool, 2> open = {true, true};
    while (open[0] || open[1]) {
        std::array<pollfd, 2> wait{};
        for (size_t i = 0; i < 2; ++i) wait[i] = {open[i] ? pipes[i][0] : -1, POLLIN, 0};
        if (::poll(wait.data(), wait.size(), -1) < 0 && errno != EINTR) break;
        for (size_t i = 0; i < 2; ++i) {
            if (!open[i] || wait[i].revents == 0) continue;
            char block[4096];
            const ssize_t got = ::read(pipes[i][0], block, sizeof block);
            if (got > 0)
                texts[i]->append(block, size_t(got));
            else if (got == 0 || errno != EINTR)
                open[i] = false;
        }
    }
    for (auto& ends : pipes) ::close(ends[0]);
    int status = 0;
    while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;
    result.status = status_of(status);
    return result;
}

pid_t start_process(const std::vector<std::string>& arguments, const std::string& log) {
    const std::vector<char*> argv = pointers(arguments);
    const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (out < 0) throw Error(fmt::format("{}: cannot write it: {}", log, std::strerror(errno)));
    const pid_t parent = ::getpid(), pid = ::fork();
    if (pid < 0) cannot_start(arguments[0]);
    if (pid == 0) {
        ::setpgid(0, 0);
        ::prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (::getppid() != parent) _exit(130);
        const int none = ::open("/dev/null", O_RDONLY);
        ::dup2(none, STDIN_FILENO);
        ::dup2(out, STDOUT_FILENO);
        ::dup2(out, STDERR_FILENO);
        become(argv);
    }
    ::setpgid(pid, pid);  // here too: whoever is first
    ::close(out);
    return pid;
}

int poll_process(pid_t pid) {
    int status = 0;
    const pid_t ended = ::waitpid(pid, &status, WNOHANG);
    if (ended == 0 || (ended < 0 && errno == EINTR)) return -1;
    return ended < 0 ? 127 : status_of(status);
}

std::string shell_quoted(const std::string& text) {
    const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return std::isalnum(c) || std::strchr("_-./=:,+@%", c);
    });
    if (plain) return text;
    std::string quoted = "'";
    for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

std::string own_path() {
    std::error_code error;
    const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
    if (error) throw Error("cannot tell where this program is: " + error.message());
    return path.string();
}

}  // namespace weft::cli
