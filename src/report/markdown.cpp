// The report in Markdown.
#include <string>

#include "core/escape.hpp"
#include "report/page.hpp"
#include "report/uses.hpp"

namespace porepack::report {

std::string markdown_page(const Page& page) {
    std::string text = "# " + for_markdown(page.title) + "\n\n";
    if (!page.summary.empty()) text += for_markdown(page.summary) + "\n\n";
    for (const auto& sentence : page.answer.sentences)
        text += (&sentence == page.answer.sentences.data() ? "**" + for_markdown(sentence) + "**" : for_markdown(sentence)) + "\n\n";
    for (const auto& note : page.notes) text += "> " + for_markdown(note) + "\n\n";
    for (const auto& [label, number] : page.main_numbers) text += "- " + for_markdown(label) + ": **" + for_markdown(number) + "**\n";
    for (const auto& section : page.sections) {
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
    text += "\n## Versions and configuration\n\n```json\n" + page.versions.dump(2) + "\n" + page.configuration.dump(2) + "\n```\n";
    return text;
}

}  // namespace porepack::report
