#include "fracture/io/atomic_file.h"

#include <csignal>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/fracture/mesh_checks.h"

using namespace brittle::fracture;
namespace fs = std::filesystem;

namespace {

Result<void> write_text(const fs::path& file, const std::string& text) {
    return write_file_atomically(file, std::as_bytes(std::span(text)));
}

bool contains(const Error& error, const std::string& text) {
    return error.message.find(text) != std::string::npos;
}

} // namespace

TEST_CASE("writing to a missing folder fails with its name and creates nothing") {
    const test::Folder folder;
    const Result<void> result = write_text(folder.path / "missing" / "a.glb", "x");
    REQUIRE(!result);
    CHECK(result.error().status == Status::write_failed);
    CHECK(contains(result.error(), "missing/a.glb"));
    CHECK(contains(result.error(), "No such file or directory"));
    CHECK(folder.files() == 0);
}

TEST_CASE("a folder and an empty name are not valid targets") {
    const test::Folder folder;
    const Result<void> result = write_text(folder.path, "x");
    REQUIRE(!result);
    CHECK(contains(result.error(), "Is a directory"));
    CHECK(folder.files() == 0);
    CHECK(!write_text("", "x"));
}

TEST_CASE("a folder without write permission is an error") {
    const test::Folder folder;
    REQUIRE(::chmod(folder.path.c_str(), 0555) == 0);
    // Permissions do not apply to root, so the test drops its privileges for a moment.
    const bool root = ::geteuid() == 0;
    if (root) REQUIRE(::seteuid(65534) == 0);
    const Result<void> result = write_text(folder.path / "a.glb", "x");
    if (root) REQUIRE(::seteuid(0) == 0);
    REQUIRE(!result);
    CHECK(contains(result.error(), "Permission denied"));
    CHECK(::chmod(folder.path.c_str(), 0755) == 0);
    CHECK(folder.files() == 0);
}

TEST_CASE("a full device is an error and stays a device") {
    const Result<void> result = write_text("/dev/full", "x");
    REQUIRE(!result);
    CHECK(contains(result.error(), "No space left on device"));
    CHECK(fs::is_character_file("/dev/full"));
}

TEST_CASE("where writing fails midway the old file stays and no temporary one is left") {
    const test::Folder folder;
    const fs::path file = folder.path / "pieces.glb";
    REQUIRE(write_text(file, "old"));

    // A limit on the file size fails like a full disk, after some bytes.
    rlimit before{};
    REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{1000, before.rlim_max};
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
    const Result<void> result = write_text(file, std::string(5000, 'n'));
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
    std::signal(SIGXFSZ, handler);

    REQUIRE(!result);
    CHECK(contains(result.error(), "File too large"));
    CHECK(contains(result.error(), "old file is unchanged"));
    CHECK(test::read_text(file) == "old");
    CHECK(folder.files() == 1);
}

TEST_CASE("writing makes a file, replaces it, and leaves nothing else") {
    const test::Folder folder;
    const fs::path file = folder.path / (std::string(250, 'n') + ".glb"); // the maximum length of a name
    REQUIRE(write_text(file, std::string(100000, 'a')));
    CHECK(test::read_text(file) == std::string(100000, 'a'));
    REQUIRE(write_text(file, ""));
    CHECK(test::read_text(file).empty());
    CHECK(folder.files() == 1);
}

TEST_CASE("relative paths are relative to the working folder") {
    const test::Folder folder;
    const fs::path before = fs::current_path();
    fs::current_path(folder.path);
    const bool plain = write_text("plain.glb", "1").has_value();
    fs::create_directory("sub");
    const bool below = write_text("sub/../sub/below.glb", "2").has_value();
    fs::current_path(before);
    CHECK(plain);
    CHECK(below);
    CHECK(test::read_text(folder.path / "plain.glb") == "1");
    CHECK(test::read_text(folder.path / "sub" / "below.glb") == "2");
}

TEST_CASE("permissions survive, and a symbolic link stays one") {
    const test::Folder folder;
    const fs::path file = folder.path / "real.glb";
    const fs::path link = folder.path / "link.glb";
    REQUIRE(write_text(file, "old"));
    REQUIRE(::chmod(file.c_str(), 0640) == 0);
    fs::create_symlink("real.glb", link);
    REQUIRE(write_text(link, "new"));
    CHECK(fs::is_symlink(link));
    CHECK(test::read_text(file) == "new");
    CHECK(fs::status(file).permissions() == static_cast<fs::perms>(0640));
}

TEST_CASE("files that a killed process staged are deleted by the next one that writes to the folder") {
    const test::Folder folder;
    const auto staged_by_child = [&](bool dies) {
        int ready[2], stop[2];
        REQUIRE(::pipe(ready) == 0);
        REQUIRE(::pipe(stop) == 0);
        const pid_t child = ::fork();
        if (child == 0) {
            const std::string text(1000, 'x');
            const auto staged = StagedFile::write(folder.path / "staged.glb", std::as_bytes(std::span(text)));
            char c = staged ? 'y' : 'n';
            if (::write(ready[1], &c, 1) != 1) ::_exit(1);
            if (!dies && ::read(stop[0], &c, 1) < 0) ::_exit(1);
            ::_exit(0); // without destructors
        }
        char c = 0;
        REQUIRE(::read(ready[0], &c, 1) == 1);
        CHECK(c == 'y');
        return std::pair(child, stop[1]);
    };
    const auto wait_for = [](pid_t child) { REQUIRE(::waitpid(child, nullptr, 0) == child); };
    const auto dead = staged_by_child(true);
    wait_for(dead.first);
    CHECK(folder.files() == 1);
    const auto alive = staged_by_child(false); // it deletes those of the dead one
    CHECK(folder.files() == 1);
    REQUIRE(write_text(folder.path / "a.glb", "a"));
    CHECK(folder.files() == 2);
    const char go = 'g';
    REQUIRE(::write(alive.second, &go, 1) == 1);
    wait_for(alive.first);
}

TEST_CASE("staged files appear together, or not at all") {
    const test::Folder folder;
    const std::string text = "text";
    {
        std::vector<StagedFile> staged;
        for (const char* name : {"a", "b"}) {
            Result<StagedFile> one = StagedFile::write(folder.path / name, std::as_bytes(std::span(text)));
            REQUIRE(one);
            staged.push_back(*std::move(one));
        }
        CHECK_FALSE(fs::exists(folder.path / "a"));
    }
    CHECK(folder.files() == 0);
    Result<StagedFile> one = StagedFile::write(folder.path / "a", std::as_bytes(std::span(text)));
    REQUIRE(one);
    REQUIRE(one->commit());
    CHECK(test::read_text(folder.path / "a") == text);
    CHECK(folder.files() == 1);
}
