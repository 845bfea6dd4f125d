#include "tools/stress/isolate.h"

#include <csignal>
#include <cstring>
#include <new>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace brittle::stress {

namespace {

// A sanitizer reserves terabytes of address space, so the limit of memory is off.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool can_limit_memory = false;
#else
constexpr bool can_limit_memory = true;
#endif

[[noreturn]] void run_child(int out, const std::function<std::string()>& function, unsigned seconds,
                            size_t memory_bytes) {
    if (const int nowhere = open("/dev/null", O_WRONLY); nowhere >= 0)
        dup2(nowhere, STDERR_FILENO); // silences the abort message of glibc
    const rlimit time{seconds, seconds + 1}, memory{memory_bytes, memory_bytes}, core{0, 0};
    setrlimit(RLIMIT_CPU, &time);
    setrlimit(RLIMIT_CORE, &core);
    if (can_limit_memory) setrlimit(RLIMIT_AS, &memory);
    alarm(10 * seconds + 10); // a deadlock uses no processor time
    std::string text;
    try {
        text = function();
    } catch (const std::bad_alloc&) {
        text = "out of memory";
    } catch (...) {
        text = "an exception escaped";
    }
    for (size_t done = 0; done < text.size();) {
        const ssize_t n = write(out, text.data() + done, text.size() - done);
        if (n <= 0) break;
        done += static_cast<size_t>(n);
    }
    _exit(0);
}

} // namespace

std::string isolated(const std::function<std::string()>& function, unsigned seconds, size_t memory_bytes) {
    int ends[2];
    if (pipe(ends) != 0) return std::string("cannot make a pipe: ") + std::strerror(errno);
    const pid_t child = fork();
    if (child < 0) return std::string("cannot fork: ") + std::strerror(errno);
    if (child == 0) {
        close(ends[0]);
        run_child(ends[1], function, seconds, memory_bytes);
    }
    close(ends[1]);
    std::string text;
    char buffer[4096];
    for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<size_t>(n));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) {
        const int signal = WTERMSIG(status);
        if (signal == SIGXCPU || signal == SIGALRM || signal == SIGKILL) return "ran out of time";
        return std::string("crashed: ") + strsignal(signal);
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) != 0)
        return "ended with status " + std::to_string(WEXITSTATUS(status));
    return text;
}

} // namespace brittle::stress
