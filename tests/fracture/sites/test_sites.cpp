#include "fracture/sites/sites.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <doctest/doctest.h>

using namespace brittle::fracture;

namespace {

// A temporary file, removed at the end of its scope.
class TemporaryFile {
  public:
    explicit TemporaryFile(const std::string& content) {
        static int serial = 0;
        const auto stamp = std::to_string(std::hash<std::string>{}(content)) + "_" + std::to_string(serial++);
        path_ = std::filesystem::temp_directory_path() / ("brittle_sites_" + stamp + ".txt");
        std::ofstream(path_, std::ios::binary) << content;
    }
    ~TemporaryFile() {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

void check_error(const std::string& content, Status status, const std::string& where, const std::string& what) {
    CAPTURE(content.substr(0, 80));
    const TemporaryFile file(content);
    const auto sites = read_sites(file.path());
    REQUIRE_FALSE(sites.has_value());
    CAPTURE(sites.error().message);
    CHECK(sites.error().status == status);
    CHECK(sites.error().message.starts_with(file.path().string() + where));
    CHECK(sites.error().message.find(what) != std::string::npos);
}

} // namespace

TEST_CASE("an error for a missing file or a folder names it") {
    const auto missing = read_sites("no/such/sites.txt");
    REQUIRE_FALSE(missing.has_value());
    CHECK(missing.error().status == Status::file_not_found);
    CHECK(missing.error().message.find("no/such/sites.txt") != std::string::npos);
    const auto folder = read_sites(std::filesystem::temp_directory_path());
    REQUIRE_FALSE(folder.has_value());
    CHECK(folder.error().message.find("folder") != std::string::npos);
}

TEST_CASE("a file without a site is an error") {
    check_error("", Status::invalid_sites, ": ", "holds no site");
    check_error("# only a comment\n\n   \t\r\n", Status::invalid_sites, ": ", "holds no site");
}

TEST_CASE("errors name the line and the offending text") {
    check_error("0 0 0\n1 2\n", Status::malformed_file, ":2: ", "z is missing in '1 2'");
    check_error("1\n", Status::malformed_file, ":1: ", "y is missing");
    check_error("# one\n# two\n1 2 x3\n", Status::malformed_file, ":3: ", "found 'x3'");
    check_error("1 2 3 4 5\n", Status::malformed_file, ":1: ", "found more text: '5'");
    check_error("1 2 3d\n", Status::malformed_file, ":1: ", "comma before 'd'");
    check_error("1 2 3 x\n", Status::malformed_file, ":1: ", "found 'x'");
    check_error("1 2 3 -4\n", Status::invalid_sites, ":1: ", "negative");
    check_error("1-2 3\n", Status::malformed_file, ":1: ", "comma before '-2 3'");
    check_error("1,,2,3\n", Status::malformed_file, ":1: ", "found ',2,3'");
    check_error(", 1 2 3\n", Status::malformed_file, ":1: ", "found ', 1 2 3'");
    check_error("+-1 2 3\n", Status::malformed_file, ":1: ", "found '+-1 2 3'");
    check_error("1 2 3,\n", Status::malformed_file, ":1: ", "radius is missing in '1 2 3,'");
    check_error("1,2,\n", Status::malformed_file, ":1: ", "z is missing");
}

TEST_CASE("numbers that are not finite or do not fit a double are refused") {
    check_error("1 2 3\nnan 0 0\n", Status::invalid_sites, ":2: ", "'nan'");
    check_error("0 -inf 0\n", Status::invalid_sites, ":1: ", "'-inf'");
    check_error("0 0 infinity\n", Status::invalid_sites, ":1: ", "'infinity'");
    check_error("0 1e999 0\n", Status::invalid_sites, ":1: ", "'1e999'");
}

TEST_CASE("endless lines and binary files give a printable error") {
    check_error(std::string(100'000, '7'), Status::malformed_file, ":1: ", "longer than 4096 bytes");
    check_error(std::string("glTF\0\x02\x1b[31m\n", 12), Status::malformed_file, ":1: ", "'glTF???[31m'");
    check_error("0 0 0\n" + std::string(5000, ' ') + "1 2 3\n", Status::malformed_file, ":2: ", "longer than");
}

TEST_CASE("every accepted spelling gives the same sites") {
    const TemporaryFile file("\xef\xbb\xbf# header\r\n"
                             "1 2 3\r\n"
                             "\t 1,2,3  \n"
                             "\n"
                             "+1.0 , 2e0\t3.0 # remark\n"
                             "10e-1\t 0.2E1 , 3"); // no newline at the end
    const auto sites = read_sites(file.path());
    REQUIRE(sites.has_value());
    CHECK(sites->sites == std::vector<glm::dvec3>(4, glm::dvec3(1, 2, 3)));
    CHECK(sites->weights.empty());
}

TEST_CASE("numbers are read to the last bit") {
    const TemporaryFile file("0.1 -1e-300 123456789.123456789\n");
    const auto sites = read_sites(file.path());
    REQUIRE(sites.has_value());
    CHECK(sites->sites[0] == glm::dvec3(0.1, -1e-300, 123456789.123456789));
}

TEST_CASE("a fourth number is a radius, whose square is the weight") {
    const TemporaryFile file("0 0 0\n1 0 0, 0.5\n2 0 0 3 # a large one\n3 0 0\n");
    const auto sites = read_sites(file.path());
    REQUIRE(sites.has_value());
    CHECK(sites->sites.size() == 4);
    CHECK(sites->weights == std::vector<double>{0.0, 0.25, 9.0, 0.0});
}

TEST_CASE("a count of zero gives no sites") {
    CHECK(uniform_sites({}, 0, 1).empty());
}

TEST_CASE("uniform sites lie in the box, repeat for equal seeds and extend shorter lists") {
    const Box box{{-1, 2, 5}, {3, 2.5, 50}};
    const auto sites = uniform_sites(box, 1000, 42);
    REQUIRE(sites.size() == 1000);
    glm::dvec3 sum(0.0);
    for (const glm::dvec3& s : sites) {
        for (int k = 0; k < 3; ++k) CHECK((s[k] >= box.min[k] && s[k] <= box.max[k]));
        sum += (s - box.min) / box.size();
    }
    // The mean of 1000 uniform numbers has standard deviation 0.009.
    for (int k = 0; k < 3; ++k) CHECK(sum[k] / 1000 == doctest::Approx(0.5).epsilon(0.08));

    CHECK(uniform_sites(box, 1000, 42) == sites);
    const auto fewer = uniform_sites(box, 10, 42);
    CHECK(std::equal(fewer.begin(), fewer.end(), sites.begin()));
    CHECK(uniform_sites(box, 10, 43) != fewer);
}

TEST_CASE("the first site of seed 1 is the same on every machine") {
    const auto sites = uniform_sites({{0, 0, 0}, {1, 1, 1}}, 1, 1);
    // SplitMix64 with seed 1 starts 0x910a2dec89025cc1, 0xbeeb8da1658eec67, 0xf893a2eefb32555e.
    const auto unit = [](uint64_t word) { return static_cast<double>(word >> 11) * 0x1.0p-53; };
    CHECK(sites[0] == glm::dvec3(unit(0x910a2dec89025cc1), unit(0xbeeb8da1658eec67), unit(0xf893a2eefb32555e)));
}
