// The keys and values in the text header of a NRRD file or a MetaImage.
#pragma once

#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/files.hpp"

namespace porepack::imaging {

class HeaderFields {
public:
    /// `format` for messages: "NRRD image".
    HeaderFields(core::Path path, std::string format) : path_(std::move(path)), format_(std::move(format)) {}

    /// A line of at most 64 KiB of header together, without its end and trailing blanks. False at the end of the file.
    bool read_line(std::ifstream& file, std::string& line);
    /// Refuses a key that is there already.
    void add(const std::string& key, const std::string& value);

    [[nodiscard]] bool contains(const std::string& key) const { return fields_.contains(key); }
    [[nodiscard]] std::string text(const std::string& key, const std::string& standard = {}) const;
    /// So many finite numbers, perhaps in brackets and with commas.
    [[nodiscard]] std::vector<double> numbers(const std::string& key, std::size_t count) const;
    /// Three whole numbers from 1 on.
    [[nodiscard]] std::array<std::int64_t, 3> sizes(const std::string& key) const;
    /// The one of these names, which mean the same, that the header has; empty if it has none.
    [[nodiscard]] std::string only_one_of(const std::vector<std::string>& names) const;
    /// "KEY: VALUE" and what is allowed.
    [[noreturn]] void refuse(const std::string& key, const std::string& allowed, const std::string& fix = {}) const;
    [[noreturn]] void fail(const std::string& what, const std::string& allowed = {}, const std::string& fix = {}) const;

    /// The file with the values. A name of a file elsewhere is said.
    [[nodiscard]] core::Path data_file(const std::string& name) const;
    /// Bytes to pass over in the file of the values, which has `value_bytes` of them; -1: the values are the last ones.
    [[nodiscard]] std::uint64_t skip(const std::string& key, const core::Path& data, double value_bytes) const;

private:
    core::Path path_;
    std::string format_;
    std::size_t length_ = 0;
    std::map<std::string, std::string> fields_;
};

}  // namespace porepack::imaging
