#include "tools/scenario/replay/log.h"

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>

#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/replay/action_json.h"
#include "tools/scenario/replay/body_text.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

constexpr int version = 1;
constexpr size_t max_line_bytes = size_t{16} << 20; // a million bodies take four MiB
constexpr uint64_t max_steps = 1'000'000'000;

uint64_t read_hash(JsonReader& reader, const char* key) {
    std::string text;
    reader.text(key, text);
    uint64_t hash = 0;
    const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), hash, 16);
    if (text.size() != 16 || error != std::errc{} || at != text.data() + text.size())
        throw reader.failure(key, "expected sixteen hexadecimal digits, found " + shown(text));
    return hash;
}

template<class Whole>
void required_whole(JsonReader& reader, const char* key, Whole& target, uint64_t max) {
    if (!reader.find(key)) throw reader.failure(key, "is missing");
    reader.whole(key, target, 0, max);
}

// Reads the lines of a log one after the other. `where` in the functions below is the file with the line number, for
// messages.
class LogReader {
  public:
    explicit LogReader(const std::filesystem::path& file) : file_(file), stream_(file, std::ios::binary) {
        if (!stream_)
            throw Failure(exit_input, file.string() + ": the replay log cannot be read: " + std::strerror(errno));
    }

    ReplayLog read() {
        const std::optional<std::string> first = next_line();
        if (!first) throw Failure(exit_input, file_.string() + ": the replay log is empty");
        read_header(*first);
        while (const std::optional<std::string> line = next_line()) {
            if (!log_.end.empty()) throw Failure(exit_input, where().string() + ": nothing may follow the end");
            read_entry(*line);
        }
        if (log_.end.empty())
            throw Failure(exit_input, file_.string() + ": the replay log has no end; it was cut after line "
                                          + std::to_string(line_));
        return std::move(log_);
    }

  private:
    [[nodiscard]] std::filesystem::path where() const { return file_.string() + ":" + std::to_string(line_); }

    std::optional<std::string> next_line() {
        std::string line;
        ++line_;
        for (char c = 0; stream_.get(c) && c != '\n';) {
            line.push_back(c);
            if (line.size() > max_line_bytes)
                throw Failure(exit_input, where().string() + ": the line is too long for a replay log");
        }
        if (line.empty() && !stream_) {
            --line_;
            return {};
        }
        return line;
    }

    void read_header(const std::string& line) {
        const std::filesystem::path at = where();
        const Json json = parse_json(at, line, "replay log");
        JsonReader reader(at, json, "");
        int written_for = 0;
        reader.whole("brittle_log", written_for, 0, INT32_MAX);
        if (written_for != version)
            throw reader.failure("brittle_log", "expected the log's version, which is " + std::to_string(version));
        if (const Json* build = reader.find("build")) log_.build = *build;
        if (!log_.build.is_object()) throw reader.failure("build", "expected an object { } that says what recorded it");
        if (!reader.find("step_seconds")) throw reader.failure("step_seconds", "is missing");
        reader.number("step_seconds", log_.step_seconds, 1e-6, 1.0);
        required_whole(reader, "pieces", log_.pieces, UINT32_MAX);
        log_.pieces_hash = read_hash(reader, "pieces_hash");
        const Json* recipe = reader.find("recipe");
        if (!recipe) throw reader.failure("recipe", "is missing");
        read_recipe(at, *recipe, "/recipe", log_.recipe);
        reader.refuse_unknown_keys();
    }

    void read_entry(const std::string& line) {
        const std::filesystem::path at = where();
        const Json json = parse_json(at, line, "replay log");
        JsonReader reader(at, json, "");
        if (reader.find("step")) {
            uint64_t step = 0;
            reader.whole("step", step, 0, max_steps);
            if (step != log_.states.size())
                throw reader.failure("step", "expected step " + std::to_string(log_.states.size()) + ", found "
                                                 + std::to_string(step));
            ReplayLog::State& state = log_.states.emplace_back();
            state.hash = read_hash(reader, "hash");
            reader.text("bodies", state.bodies);
            if (!count_bodies(state.bodies))
                throw reader.failure("bodies",
                                     "expected four hexadecimal digits per body, or (N) for N unchanged bodies");
        } else if (reader.find("commit")) {
            const uint64_t after = step_now(reader, "after");
            JsonReader inner(at, *reader.find("commit"), "/commit");
            uint32_t job = 0;
            required_whole(inner, "job", job, UINT32_MAX);
            inner.refuse_unknown_keys();
            if (!may_break()) throw reader.failure("commit", "a commit needs a recipe whose world is breakable");
            log_.commits.push_back({after + 1, job});
        } else if (reader.find("after")) {
            log_.actions.emplace_back(step_now(reader, "after"), Action{});
            std::optional<Action> action = read_action(at, reader, piece_numbers());
            if (!action) throw reader.failure("after", "there is no action in this line");
            log_.actions.back().second = *std::move(action);
        } else if (reader.find("end")) {
            step_now(reader, "steps");
            reader.text("end", log_.end);
            if (log_.end.empty()) throw reader.failure("end", "expected the reason for the end, e.g. \"finished\"");
        } else {
            throw reader.failure("", "expected a line with step, after or end");
        }
        reader.refuse_unknown_keys();
    }

    // Exclusive limit of the piece numbers in actions. In a breakable world new pieces may have any number.
    [[nodiscard]] size_t piece_numbers() const { return may_break() ? UINT32_MAX : log_.pieces; }
    [[nodiscard]] bool may_break() const { return log_.recipe.world.breakable || is_scene(log_.recipe); }

    // Reads a number of steps, which must be that of the last state read.
    uint64_t step_now(JsonReader& reader, const char* key) {
        uint64_t step = 0;
        required_whole(reader, key, step, max_steps);
        if (log_.states.empty()) throw reader.failure(key, "there is no state before this line");
        if (step + 1 != log_.states.size())
            throw reader.failure(key, "expected " + std::to_string(log_.states.size() - 1)
                                          + ", the step of the last state, found " + std::to_string(step));
        return step;
    }

    const std::filesystem::path& file_;
    std::ifstream stream_;
    uint64_t line_ = 0;
    ReplayLog log_;
};

} // namespace

ReplayLog read_replay_log(const std::filesystem::path& file) {
    return LogReader(file).read();
}

std::string hash_text(uint64_t hash) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

std::string header_line(const ReplayLog& log, const std::filesystem::path& folder) {
    const Json json{{"brittle_log", version},
                    {"build", log.build},
                    {"step_seconds", log.step_seconds},
                    {"pieces", log.pieces},
                    {"pieces_hash", hash_text(log.pieces_hash)},
                    {"recipe", recipe_object(log.recipe, folder)}};
    return text_of(json) + "\n";
}

std::string state_line(uint64_t step, const ReplayLog::State& state) {
    return R"({"step":)" + std::to_string(step) + R"(,"hash":")" + hash_text(state.hash) + R"(","bodies":")"
           + state.bodies + "\"}\n";
}

std::string action_line(uint64_t step, const Action& action) {
    Json json{{"after", step}};
    write_action(json, action);
    return json.dump() + "\n";
}

std::string commit_line(const physics::Commit& commit) {
    return Json{{"after", commit.step - 1}, {"commit", {{"job", commit.job}}}}.dump() + "\n";
}

std::string end_line(uint64_t steps, const std::string& end) {
    return Json{{"end", end}, {"steps", steps}}.dump() + "\n";
}

} // namespace brittle::tools
