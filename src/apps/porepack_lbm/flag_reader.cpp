#include "apps/porepack_lbm/flag_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/error.hpp"

namespace porepack::apps {
namespace {

using core::UserError;

double number_in(const std::string& flag, const std::string& text, const record::Range& range) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !std::isfinite(value) || !range.holds(value))
        throw UserError(fmt::format("{} {}", flag, text), {.allowed = range.text()});
    return value;
}

}  // namespace

FlagReader::FlagReader(const std::vector<std::string>& words, std::vector<std::string> without) : without_(std::move(without)) {
    for (std::size_t i = 0; i < words.size(); i += 2) {
        if (!words[i].starts_with("--")) throw UserError(fmt::format("\"{}\" is no flag", words[i]), {.fix = "porepack_lbm --help"});
        if (i + 1 == words.size()) throw UserError(fmt::format("{} has no value", words[i]), {.fix = "porepack_lbm --help"});
        if (!values_.emplace(words[i], words[i + 1]).second) throw UserError(fmt::format("{} is there twice", words[i]));
    }
}

void FlagReader::require_all_read() const {
    for (const auto& [flag, value] : values_)
        if (std::find(known_.begin(), known_.end(), flag) == known_.end())
            throw UserError(fmt::format("unknown flag {}", flag), {.fix = record::perhaps(record::nearest(flag, known_))});
}

const std::string* FlagReader::find(const char* key) {
    if (std::find(without_.begin(), without_.end(), key) != without_.end()) return nullptr;
    known_.push_back(record::flag_of(key));
    const auto found = values_.find(known_.back());
    return found == values_.end() ? nullptr : &found->second;
}

void FlagReader::number(const char* key, double& value, const record::Range& range, const char*) {
    if (const std::string* text = find(key)) value = number_in(known_.back(), *text, range);
}

void FlagReader::integer(const char* key, long& value, const record::Range& range, const char*) {
    const std::string* text = find(key);
    if (text == nullptr) return;
    const double number = number_in(known_.back(), *text, range);
    if (number != std::round(number)) throw UserError(fmt::format("{} {}", known_.back(), *text), {.allowed = "a whole number"});
    value = std::lround(number);
}

void FlagReader::boolean(const char* key, bool& value, const char*) {
    const std::string* text = find(key);
    if (text == nullptr) return;
    if (*text != "true" && *text != "false") throw UserError(fmt::format("{} {}", known_.back(), *text), {.allowed = "true, false"});
    value = *text == "true";
}

void FlagReader::text(const char* key, std::string& value, const char*) {
    if (const std::string* text = find(key)) value = *text;
}

void FlagReader::word(const char* key, std::string& value, const std::vector<std::string>& allowed, const char*) {
    const std::string* text = find(key);
    if (text == nullptr) return;
    if (std::find(allowed.begin(), allowed.end(), *text) == allowed.end())
        throw UserError(fmt::format("{} {}", known_.back(), *text), {.allowed = fmt::format("{}", fmt::join(allowed, ", "))});
    value = *text;
}

void FlagReader::numbers(const char* key, std::vector<double>& values, std::pair<std::size_t, std::size_t> sizes,
                         const record::Range& range, const char*) {
    const std::string* text = find(key);
    if (text == nullptr) return;
    values.clear();
    for (std::size_t begin = 0; begin <= text->size();) {
        const std::size_t end = std::min(text->find(',', begin), text->size());
        values.push_back(number_in(known_.back(), text->substr(begin, end - begin), range));
        begin = end + 1;
    }
    if (values.size() < sizes.first || values.size() > sizes.second)
        throw UserError(fmt::format("{} {}", known_.back(), *text),
                        {.allowed = fmt::format("{} numbers with commas between them", sizes.first)});
}

}  // namespace porepack::apps
