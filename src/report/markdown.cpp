// The report in Markdown.
#include "core/escape.hpp"
#include "report/section.hpp"

namespace porepack::report {
using namespace core;

std::string markdown_page(const ReportInput& input, const std::vector<ReportSection>& sections, const Json& main_numbers) {
    std::string text = "# " + for_markdown(input.title) + "\n\n";
    if (!input.summary.empty()) text += for_markdown(input.summary) + "\n\n";
    for (const auto& note : input.notes) text += "> " + for_markdown(note) + "\n\n";
    for (const auto& entry : main_numbers)
        text += "- " + for_markdown(entry["label"].get<std::string>()) + ": **" + for_markdown(entry["text"].get<std::string>()) + "**\n";
    for (const auto& section : sections) {
        if (section.rows.empty() && section.pictures.empty()) continue;
        text += "\n## " + for_markdown(section.title) + "\n\n";
        if (!section.intro.empty()) text += for_markdown(section.intro) + "\n\n";
        std::string rule = "|";
        text += "|";
        for (const auto& head : section.header) {
            text += " " + for_markdown(head) + " |";
            rule += "---|";
        }
        text += "\n" + rule + "\n";
        for (const auto& row : section.rows) {
            text += "|";
            for (const auto& cell : row) text += " " + for_markdown(cell) + " |";
            text += "\n";
        }
        for (const auto& [file, caption] : section.pictures)
            text += "\n![" + for_markdown(caption) + "](report/" + file + ")\n*" + for_markdown(caption) + "*\n";
    }
    text += "\n## Versions and configuration\n\n```json\n" + input.versions.dump(2) + "\n" + input.configuration.dump(2) + "\n```\n";
    return text;
}

}  // namespace porepack::report
