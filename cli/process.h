// Other programs: run one and read what it says, or start one that writes to a log.
#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

namespace weft::cli {

struct ProcessResult {
    int status = 0;  // exit status; 127: no such program; 128 + n: ended by signal n
    std::string out, err;
};
// Waits for it. Throws Error if the system cannot start a process.
ProcessResult run_process(const std::vector<std::string>& arguments);

// Starts it in a process group of its own, its output added to `log`; it ends with this program.
pid_t start_process(const std::vector<std::string>& arguments, const std::string& log);
// The status as above, or -1 while it runs.
int poll_process(pid_t pid);

// One word for /bin/sh.
std::string shell_quoted(const std::string& text);
// This program's file.
std::string own_path();

}  // namespace weft::cli
