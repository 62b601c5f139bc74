#include "cli/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>

namespace weft::cli {
namespace {

std::atomic<bool> interrupted_flag = false;

void on_signal(int) {
    if (interrupted_flag.exchange(true)) _exit(130);
}

void to_stderr(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stderr); }

std::string seconds_text(double seconds) {
    if (seconds < 99.5) return fmt::format("{:.0f} s", seconds);
    return fmt::format("{:.0f} min {:02.0f} s", std::floor(seconds / 60), std::fmod(seconds, 60));
}

struct Look {
    std::string name, unit;
    double finished, total, elapsed;
};

std::vector<Look> running_tasks(const Monitor& monitor) {
    std::vector<Look> looks;
    for (const TaskProgress& task : monitor.tasks)
        if (task.state == TaskProgress::running)
            looks.push_back({task.name, task.unit.load(), task.finished, task.total,
                             double(now_us() - task.started_us) * 1e-6});
    return looks;
}

// " 37 %  120 of 320 tiles  41 tiles/s  5 s left"
std::string measure_text(const Look& look) {
    if (look.total <= 0) return seconds_text(look.elapsed);
    const double part = std::clamp(look.finished / look.total, 0.0, 1.0);
    std::string text = fmt::format("{:3.0f} %  {:.0f} of {:.0f} {}", part * 100, look.finished, look.total, look.unit);
    if (look.elapsed > 0.5 && look.finished > 0) {
        const double rate = look.finished / look.elapsed;
        text += fmt::format("  {:.3g} {}/s  {} left", rate, look.unit, seconds_text((look.total - look.finished) / rate));
    }
    return text;
}

}  // namespace

bool stderr_is_terminal() {
    static const bool terminal = isatty(STDERR_FILENO) != 0;
    return terminal;
}

bool use_color() {
    const char* no_color = std::getenv("NO_COLOR");
    return stderr_is_terminal() && !(no_color && *no_color);
}

void print(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fflush(stdout);
}

void complain(const std::string& message) { to_stderr(fmt::format("weft: {}\n", message)); }

void print_findings(const std::vector<Diagnostic>& findings) {
    for (const Diagnostic& finding : findings) {
        std::string text = to_text(finding, use_color());
        if (text.empty() || text.back() != '\n') text += '\n';
        to_stderr(text);
    }
}

ProgressDisplay::ProgressDisplay(Monitor& monitor, bool quiet) : monitor_(monitor), terminal_(stderr_is_terminal()) {
    if (quiet) return;
    thread_ = std::thread([this] {
        const auto pause = std::chrono::milliseconds(terminal_ ? 100 : 5000);
        std::unique_lock lock(mutex_);
        while (!wake_.wait_for(lock, pause, [this] { return end_; })) terminal_ ? draw_bars() : print_lines();
        erase_bars();
    });
}

ProgressDisplay::~ProgressDisplay() {
    {
        const std::lock_guard lock(mutex_);
        end_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void ProgressDisplay::note(const std::string& line) {
    const std::lock_guard lock(mutex_);
    erase_bars();
    to_stderr(line + "\n");
}

void ProgressDisplay::erase_bars() {
    if (drawn_ > 0) to_stderr(fmt::format("\x1b[{}A\r\x1b[J", drawn_));
    drawn_ = 0;
}

void ProgressDisplay::draw_bars() {
    winsize size{};
    const int width = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
    const std::vector<Look> looks = running_tasks(monitor_);
    std::string text = drawn_ > 0 ? fmt::format("\x1b[{}A\r\x1b[J", drawn_) : "";
    for (const Look& look : looks) {
        constexpr int cells = 24;
        const int filled = look.total > 0 ? int(cells * std::clamp(look.finished / look.total, 0.0, 1.0)) : 0;
        std::string line = fmt::format("{:<28.28} [{}{}] {}", look.name, std::string(size_t(filled), '#'),
                                       std::string(size_t(cells - filled), '.'), measure_text(look));
        if (int(line.size()) >= width) line.resize(size_t(width - 1));
        text += line + "\n";
    }
    to_stderr(text);
    drawn_ = int(looks.size());
}

void ProgressDisplay::print_lines() {
    for (const Look& look : running_tasks(monitor_)) to_stderr(fmt::format("{}: {}\n", look.name, measure_text(look)));
}

const std::atomic<bool>& interruption() { return interrupted_flag; }

void catch_interruptions() {
    struct sigaction action {};
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace weft::cli
