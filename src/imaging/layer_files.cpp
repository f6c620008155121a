#include "imaging/layer_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <optional>

#include "core/error.hpp"

namespace porepack::imaging {
namespace fs = std::filesystem;
namespace {

bool is_digit(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

// A name without its ending: what stands between numbers, and the numbers.
struct Name {
    std::string text;  // with # for each number
    std::vector<std::string> numbers;
};

Name name_of(const Path& file) {
    Name name;
    bool in_number = false;
    for (const char c : file.stem().string()) {
        const bool digit = is_digit(c);
        if (digit && !in_number) {
            name.text += '#';
            name.numbers.emplace_back();
        }
        if (digit)
            name.numbers.back() += c;
        else
            name.text += c;
        in_number = digit;
    }
    return name;
}

// The numbers at one place of all names, or at two places as decimal fractions.
std::optional<std::vector<long long>> numbers_at(const std::vector<Name>& names, std::size_t place, bool with_next) {
    std::vector<long long> numbers;
    for (const Name& name : names) {
        std::string digits = name.numbers[place];
        if (with_next) {
            if (name.numbers[place + 1].size() != names.front().numbers[place + 1].size()) return std::nullopt;
            digits += name.numbers[place + 1];
        }
        if (digits.size() > 15) return std::nullopt;
        numbers.push_back(std::stoll(digits));
    }
    return numbers;
}

// Index of the first number that is not one step after the one before it; the size if there is none.
std::size_t first_gap(const std::vector<long long>& numbers) {
    for (std::size_t i = 1; i < numbers.size(); ++i)
        if (numbers[i] - numbers[i - 1] != numbers[1] - numbers[0] || numbers[i] <= numbers[i - 1]) return i;
    return numbers.size();
}

}  // namespace

std::string lower_extension(const Path& path) {
    std::string text = path.extension().string();
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

std::vector<Path> layers_in(const Path& folder, std::initializer_list<const char*> extensions) {
    std::vector<Path> files;
    if (fs::is_directory(folder))
        for (const auto& entry : fs::directory_iterator(folder))
            if (!entry.path().filename().string().starts_with('.') &&
                std::find(extensions.begin(), extensions.end(), lower_extension(entry.path())) != extensions.end()) {
                if (!entry.is_regular_file())
                    throw UserError("not a regular file: " + entry.path().string(),
                                    {.fix = "a layer of the image is missing or not mounted"});
                files.push_back(entry.path());
            }
    // slice_2 before slice_10.
    std::sort(files.begin(), files.end(), [](const Path& one, const Path& other) {
        const std::string a = one.filename().string(), b = other.filename().string();
        std::size_t i = 0, j = 0;
        while (i < a.size() && j < b.size()) {
            if (is_digit(a[i]) && is_digit(b[j])) {
                const auto digits = [](const std::string& text, std::size_t& at) {
                    std::string number;
                    while (at < text.size() && is_digit(text[at])) number += text[at++];
                    number.erase(0, std::min(number.find_first_not_of('0'), number.size()));
                    return number;
                };
                const std::string m = digits(a, i), n = digits(b, j);
                if (m != n) return m.size() != n.size() ? m.size() < n.size() : m < n;
            } else {
                if (a[i] != b[j]) return a[i] < b[j];
                ++i, ++j;
            }
        }
        return a.size() - i < b.size() - j;
    });
    return files;
}

void require_numbered(const std::vector<Path>& layers) {
    if (layers.size() < 2) return;
    std::map<std::string, std::vector<std::string>> groups;
    std::vector<Name> names;
    for (const Path& file : layers) {
        names.push_back(name_of(file));
        groups[names.back().text].push_back(file.filename().string());
    }
    const auto largest =
        std::max_element(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    for (const auto& [text, group] : groups) {
        if (text == largest->first) continue;
        throw UserError(fmt::format("{} is not named as {}: is it a layer?", group.front(), largest->second.front()),
                        {.where = layers.front().parent_path().string(),
                         .allowed = "names that differ in numbers only, as slice_0001.tif",
                         .fix = "move what is no layer of this image to another folder, or rename it"});
    }
    std::size_t gap = 1;
    std::vector<long long> shown;
    for (std::size_t place = 0; place < names.front().numbers.size(); ++place)
        for (const bool with_next : {false, true}) {
            if (with_next && place + 1 == names.front().numbers.size()) continue;
            const auto numbers = numbers_at(names, place, with_next);
            if (!numbers || std::all_of(numbers->begin(), numbers->end(), [&](long long n) { return n == numbers->front(); })) continue;
            const std::size_t end = first_gap(*numbers);
            if (end == layers.size()) return;
            if (shown.empty() || end > gap) {
                shown = *numbers;
                gap = end;
            }
        }
    const std::string last = layers[gap].filename().string(), before = layers[gap - 1].filename().string();
    throw UserError(shown.empty() ? "the names of the layers have no numbers that tell them apart"
                                  : fmt::format("between {} and {} the number grows by {}, before by {}: a layer is missing or twice there",
                                                before, last, shown[gap] - shown[gap - 1], gap > 1 ? shown[1] - shown[0] : 1),
                    {.where = layers.front().parent_path().string(), .fix = "number the files in equal steps"});
}

}  // namespace porepack::imaging
