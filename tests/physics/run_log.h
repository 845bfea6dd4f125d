// The log of a test's run: its initial state, its inputs by step, and hashes of its states. INFO() prints it where a
// later check of the block fails, up to the present step. A repetition with the same build prints equal lines; with
// another build, the first state that differs bounds the step at which the runs diverged.
//
//     RunLog log("300 pieces of a cube, seed 7");
//     INFO(log);
//     log.did("a ball of ", mass, " kg is shot from ", position);
//     world.step(), log.look(world);
#pragma once

#include <bit>
#include <cstdint>
#include <ostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/cutting/destruction.h"
#include "physics/world/world.h"

namespace brittle::physics {

class RunLog {
  public:
    explicit RunLog(std::string beginning) : beginning_(std::move(beginning)) {}

    // Records an input to the world, after the last recorded step.
    void did(const auto&... what) {
        std::ostringstream text;
        text.precision(9); // digits that identify every float
        (put(text, what), ...);
        inputs_.emplace_back(states_.size(), std::move(text).str());
    }
    void look(const World& world) { states_.push_back(world.state_hash()); }

    friend std::ostream& operator<<(std::ostream& stream, const RunLog& log) {
        stream << "the run: " << log.beginning_;
        for (const auto& [step, input] : log.inputs_) stream << "\n    after step " << step << ": " << input;
        for (size_t step = 1; step <= log.states_.size(); ++step)
            if (std::has_single_bit(step) || step == log.states_.size()) {
                stream << "\n    state after step " << step << ": ";
                put_hash(stream, log.states_[step - 1]);
            }
        return stream;
    }

  private:
    static void put(std::ostream& stream, const auto& value) { stream << value; }
    static void put(std::ostream& stream, const glm::vec3& v) {
        stream << '(' << v.x << ' ' << v.y << ' ' << v.z << ')';
    }
    template<typename T>
    static void put(std::ostream& stream, const std::vector<T>& values) {
        for (const T& value : values) stream << ' ', put(stream, value);
    }
    static void put(std::ostream& stream, PieceId piece) { stream << piece.value; }
    static void put_hash(std::ostream& stream, uint64_t hash) {
        for (int shift = 60; shift >= 0; shift -= 4) stream << "0123456789abcdef"[hash >> shift & 15];
    }

    std::string beginning_;
    std::vector<std::pair<size_t, std::string>> inputs_; // step, input
    std::vector<uint64_t> states_;
};

} // namespace brittle::physics
