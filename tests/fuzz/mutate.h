// What the mutators of JSON share. libFuzzer calls LLVMFuzzerCustomMutator() in place of its own changes of bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "tests/fuzz/json_mutator.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);
extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed);

namespace brittle::fuzz {

constexpr unsigned bytes_one_in = 16;     // changes that change bytes, for the reader's sake
constexpr unsigned unordered_one_in = 25; // changed logs whose steps stay as they are

inline std::string text_of(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// Writes the text into the fuzzer's buffer; one that is too long leaves a change of bytes.
inline size_t written(const std::string& text, uint8_t* data, size_t size, size_t max_size) {
    if (text.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
    std::memcpy(data, text.data(), text.size());
    return text.size();
}

} // namespace brittle::fuzz
