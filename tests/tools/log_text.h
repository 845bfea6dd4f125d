// The text of a replay log, for tests that write a log again after reading it.
#pragma once

#include <filesystem>
#include <string>

#include "tools/scenario/replay/log.h"

namespace brittle::tools::test {

// Returns the text that a recorder would write into `folder`.
inline std::string log_text(const ReplayLog& log, const std::filesystem::path& folder) {
    std::string text = header_line(log, folder);
    auto action = log.actions.begin();
    auto commit = log.commits.begin();
    for (uint64_t step = 0; step < log.states.size(); ++step) {
        for (; commit != log.commits.end() && commit->step == step; ++commit) text += commit_line(*commit);
        text += state_line(step, log.states[step]);
        for (; action != log.actions.end() && action->first == step; ++action)
            text += action_line(step, action->second);
    }
    return text + end_line(log.states.size() - 1, log.end);
}

} // namespace brittle::tools::test
