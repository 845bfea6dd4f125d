#define DOCTEST_CONFIG_IMPLEMENT // also where the header was precompiled
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include <iostream>
#include <string>
#include <string_view>

#include <unistd.h>

namespace {

// Prints, after a failed test case, the command that repeats it alone, with the BRITTLE_ variables of the environment.
class Repeat final : public doctest::IReporter {
  public:
    explicit Repeat(const doctest::ContextOptions& options) : options_(options) {}

    void test_case_start(const doctest::TestCaseData& test) override { name_ = test.m_name; }
    void test_case_end(const doctest::CurrentTestCaseStats& result) override {
        if (result.testCaseSuccess) return;
        std::string command;
        for (char** variable = environ; *variable; ++variable) {
            const std::string_view text = *variable;
            const size_t value = text.find('=') + 1;
            if (text.starts_with("BRITTLE_"))
                command += std::string(text.substr(0, value)) + quoted(text.substr(value)) + " ";
        }
        *options_.cout << std::flush;
        std::cerr << "to run it alone: " << command << quoted(options_.binary_name.c_str())
                  << " --test-case=" << quoted(pattern()) << "\n\n";
    }

    void report_query(const doctest::QueryData&) override {}
    void test_run_start() override {}
    void test_run_end(const doctest::TestRunStats&) override {}
    void test_case_reenter(const doctest::TestCaseData&) override {}
    void test_case_exception(const doctest::TestCaseException&) override {}
    void subcase_start(const doctest::SubcaseSignature&) override {}
    void subcase_end() override {}
    void log_assert(const doctest::AssertData&) override {}
    void log_message(const doctest::MessageData&) override {}
    void test_case_skipped(const doctest::TestCaseData&) override {}

  private:
    // Quotes the text for a POSIX shell.
    static std::string quoted(std::string_view text) {
        std::string result = "'";
        for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
        return result + "'";
    }
    // Returns the name of the test case as a doctest pattern: commas, which separate patterns, are escaped.
    [[nodiscard]] std::string pattern() const {
        std::string result;
        for (const char c : name_) result += c == ',' || c == '\\' ? std::string("\\") + c : std::string(1, c);
        return result;
    }

    const doctest::ContextOptions& options_;
    std::string name_;
};

DOCTEST_REGISTER_LISTENER("repeat", 0, Repeat);

} // namespace
