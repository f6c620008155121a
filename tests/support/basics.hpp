// What all tests share: a folder for files, and expectations about text and errors.
#pragma once

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/files.hpp"

namespace porepack {
using core::Json;
using core::Path;
}  // namespace porepack

namespace porepack::test {
using core::Path;

/// A folder of its own for each test, with a space and an apostrophe in its name; removed at the end.
class Folder {
public:
    Folder() {
        const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
        path_ = std::filesystem::temp_directory_path() /
                ("porepack's test " + std::string(info->test_suite_name()) + "." + info->name() + "." + std::to_string(getpid()));
        std::filesystem::remove_all(path_);
        std::filesystem::create_directories(path_);
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    [[nodiscard]] const Path& path() const { return path_; }
    Path write(const std::string& name, const std::string& text) const {
        std::filesystem::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << text;
        return path_ / name;
    }

private:
    Path path_;
};

/// For a shell.
inline std::string quoted(const std::string& text) {
    std::string quoted = "'";
    for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}
inline std::string quoted(const char* text) {
    return quoted(std::string(text));
}
inline std::string quoted(const Path& path) {
    return quoted(path.string());
}

/// The message of the error that `action` throws.
template <typename ErrorType, typename Action>
std::string message_of(Action action) {
    try {
        action();
    } catch (const ErrorType& error) {
        return error.what();
    } catch (const std::exception& other) {
        ADD_FAILURE() << "another error came: " << other.what();
        return {};
    }
    ADD_FAILURE() << "no error was thrown";
    return {};
}

inline ::testing::AssertionResult has(const std::string& text, const std::string& part) {
    if (text.find(part) != std::string::npos) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << "\"" << part << "\" is not in:\n" << text;
}

}  // namespace porepack::test
