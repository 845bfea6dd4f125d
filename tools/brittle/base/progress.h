// A progress line on standard error: rewritten in place on a terminal, silent elsewhere and with --quiet.
#pragma once

#include <chrono>
#include <string>

namespace brittle::tools {

class Progress {
  public:
    explicit Progress(std::string label);
    ~Progress(); // clears the line
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    // Shows `share`, from 0 to 1, as a percentage and, after two seconds, an estimate of the remaining time.
    void update(double share);

  private:
    std::string label_;
    bool terminal_;
    bool shown_ = false;
    std::chrono::steady_clock::time_point start_;
    std::chrono::steady_clock::time_point last_;
};

} // namespace brittle::tools
