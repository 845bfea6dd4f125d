// The main() of a fuzz target without libFuzzer.
//
//     fuzz_recipe PATH...                          # runs these files, and all files of folders
//     fuzz_recipe --mutate SECONDS SEED PATH...    # then runs changes of them, of changes too, without regard to coverage
//
// The first makes each corpus in tests/corpus/fuzz a test of every build. A broken promise ends the program by a signal.
// The last line of the output names the file; a changed input is in fuzz_input, in the working folder.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);
extern "C" [[gnu::weak]] size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed);

namespace {

using Input = std::vector<uint8_t>;

constexpr size_t max_input = 8192;  // bytes
constexpr size_t max_inputs = 2000; // that are changed further
std::minstd_rand byte_random(1);

std::vector<std::filesystem::path> files_of(int count, char** paths) {
    std::vector<std::filesystem::path> files;
    for (int k = 0; k < count; ++k) {
        if (!std::filesystem::is_directory(paths[k])) {
            files.emplace_back(paths[k]);
            continue;
        }
        for (const auto& entry : std::filesystem::directory_iterator(paths[k])) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

Input mutated(Input input, unsigned seed) {
    const size_t size = input.size();
    input.resize(std::max(max_input, size));
    input.resize(LLVMFuzzerCustomMutator ? LLVMFuzzerCustomMutator(input.data(), size, input.size(), seed)
                                         : LLVMFuzzerMutate(input.data(), size, input.size()));
    return input;
}

// Runs changed inputs for a while.
void mutate(std::vector<Input> inputs, double seconds, unsigned seed) {
    std::minstd_rand random(seed);
    byte_random.seed(seed);
    const auto begin = std::chrono::steady_clock::now();
    size_t runs = 0;
    for (; std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < seconds; ++runs) {
        Input input = mutated(inputs[random() % inputs.size()], static_cast<unsigned>(random()));
        std::ofstream("fuzz_input", std::ios::binary)
            .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
        LLVMFuzzerTestOneInput(input.data(), input.size());
        if (random() % 4 != 0) continue;
        if (inputs.size() < max_inputs)
            inputs.push_back(std::move(input));
        else
            inputs[random() % inputs.size()] = std::move(input);
    }
    std::filesystem::remove("fuzz_input");
    std::printf("%zu changed inputs\n", runs);
}

} // namespace

// libFuzzer's change of bytes: here one byte changes, comes or goes.
extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size) {
    const auto value = static_cast<uint8_t>(byte_random() >> 8);
    const size_t at = size == 0 ? 0 : byte_random() % size, way = byte_random() % 3;
    if (size == 0 || (way == 0 && size < max_size)) {
        std::memmove(data + at + 1, data + at, size - at);
        data[at] = value;
        return size + 1;
    }
    if (way == 1) {
        std::memmove(data + at, data + at + 1, size - at - 1);
        return size - 1;
    }
    data[at] = value;
    return size;
}

int main(int count, char** arguments) {
    const bool changes = count > 3 && std::strcmp(arguments[1], "--mutate") == 0;
    const int first = changes ? 4 : 1;
    std::vector<Input> inputs;
    for (const std::filesystem::path& file : files_of(count - first, arguments + first)) {
        std::printf("%s\n", file.c_str());
        std::fflush(stdout);
        std::ifstream stream(file, std::ios::binary);
        if (!stream) {
            std::fprintf(stderr, "%s: cannot be read\n", file.c_str());
            return 1;
        }
        const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
        inputs.emplace_back(bytes.begin(), bytes.end());
        LLVMFuzzerTestOneInput(inputs.back().data(), inputs.back().size());
    }
    std::printf("%zu inputs\n", inputs.size());
    if (inputs.empty()) return 1;
    if (changes) mutate(inputs, std::atof(arguments[2]), static_cast<unsigned>(std::atoi(arguments[3])));
    return 0;
}
