// Flags of a command line, read into tables by the lists of their keys (record/config.hpp).
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "record/config.hpp"

namespace porepack::apps {

/// "--voxel-size 2e-4 --tensor true" and so on. Throws UserError for a value that a key does not allow.
class FlagReader : public record::ConfigVisitor {
public:
    /// Keys `without` are no flags.
    FlagReader(const std::vector<std::string>& words, std::vector<std::string> without);
    /// Throws UserError for a flag that no table had.
    void require_all_read() const;

    void number(const char* key, double& value, const record::Range& range, const char* meaning) override;
    void integer(const char* key, long& value, const record::Range& range, const char* meaning) override;
    void boolean(const char* key, bool& value, const char* meaning) override;
    void text(const char* key, std::string& value, const char* meaning) override;
    void word(const char* key, std::string& value, const std::vector<std::string>& allowed, const char* meaning) override;
    void numbers(const char* key, std::vector<double>& values, std::pair<std::size_t, std::size_t> sizes, const record::Range& range,
                 const char* meaning) override;
    void renamed(const char*, const char*) override {}
    void booleans(const char*, std::vector<bool>&, std::size_t, const char*) override {}
    void any(const char*, core::Json&, const char*, const char*) override {}
    void tables(const char*, const std::function<std::size_t(std::size_t)>&, const std::function<void(std::size_t, ConfigVisitor&)>&,
                const char*) override {}

private:
    /// The text behind the key's flag, or null.
    [[nodiscard]] const std::string* find(const char* key);

    std::map<std::string, std::string> values_;  ///< by flag
    std::vector<std::string> known_, without_;
};

}  // namespace porepack::apps
