// What repeats the run of a test and tells whether it was repeated: what it begins with, what is done to it and when, states. From
// INFO() on it is printed where a check of the block fails, as far as the run has come. The same build gives the same lines again; with
// another one the first state that differs says by when the two had parted.
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

    // Something that is not up to the world, after the last step that was looked at.
    void did(const auto&... what) {
        std::ostringstream text;
        text.precision(9); // of a float nothing is lost
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
    std::vector<std::pair<size_t, std::string>> inputs_; // after so many steps
    std::vector<uint64_t> states_;
};

} // namespace brittle::physics
