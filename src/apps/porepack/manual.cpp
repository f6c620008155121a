// Man pages of all commands, and the completion for bash: made of what --help shows, so that they cannot differ from it.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include "apps/porepack/command_line.hpp"
#include "apps/porepack/uses.hpp"
#include "core/build.hpp"
#include "core/files.hpp"

namespace porepack::apps {
namespace {

/// A command with the words that call it, "image fit".
struct Place {
    const CLI::App* app = nullptr;
    std::string words;
};

std::vector<const CLI::App*> below(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App* each) { return !each->get_group().empty(); });
}

void collect(const CLI::App& app, const std::string& words, std::vector<Place>& places) {
    places.push_back({&app, words});
    for (const CLI::App* each : below(app)) collect(*each, words.empty() ? each->get_name() : words + " " + each->get_name(), places);
}

// Old names of flags are in no group.
std::vector<const CLI::Option*> shown_options(const CLI::App& app) {
    return app.get_options([](const CLI::Option* option) { return !option->get_group().empty(); });
}

// Text as roff: no control character at the start of a line, hyphens that can be copied.
std::string roff(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        if (escaped.empty() || escaped.back() == '\n')
            if (c == '.' || c == '\'') escaped += "\\&";
        if (c == '\\')
            escaped += "\\e";
        else if (c == '-')
            escaped += "\\-";
        else
            escaped += c;
    }
    return escaped;
}

std::string page_name(const std::string& words) {
    std::string name = words.empty() ? "porepack" : "porepack-" + words;
    std::replace(name.begin(), name.end(), ' ', '-');
    return name;
}

std::string option_entry(const CLI::Option& option) {
    const std::string type = option.get_items_expected_max() > 0 ? option.get_type_name() : "";
    const std::string& name = option.get_positional() ? option.get_name() : option.get_name(false, true);
    return fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(name), type.empty() ? "" : " \\fI" + roff(type) + "\\fR",
                       roff(option.get_description()));
}

std::string options_of(const CLI::App& app) {
    std::string text;
    for (const bool positional : {true, false}) {
        std::string part;
        for (const CLI::Option* option : shown_options(app))
            if (option->get_positional() == positional) part += option_entry(*option);
        if (!part.empty()) text += fmt::format(".SH {}\n{}", positional ? "ARGUMENTS" : "OPTIONS", part);
    }
    return text;
}

std::string synopsis_of(const Place& place) {
    std::string text = fmt::format(".SH SYNOPSIS\n\\fBporepack{}\\fR", place.words.empty() ? "" : " " + roff(place.words));
    if (!below(*place.app).empty()) return text + " \\fIcommand\\fR [\\fIoptions\\fR]\n";
    for (const CLI::Option* option : shown_options(*place.app))
        if (option->get_positional())
            text += fmt::format(" \\fI{}\\fR{}", roff(option->get_name()), option->get_items_expected_max() > 1 ? "..." : "");
    return text + " [\\fIoptions\\fR]\n";
}

// "Exit codes: ...", "Example:\n  porepack ...": the lines below --help.
std::string footer_of(const CLI::App& app) {
    const std::string& footer = app.get_footer();
    const std::string title = "Example:\n";
    const std::size_t example = footer.find(title);
    if (example == std::string::npos) return footer.empty() ? "" : fmt::format(".PP\n{}\n", roff(footer));
    std::string text;
    if (example > 0) text = fmt::format(".SH EXIT STATUS\n{}\n", roff(footer.substr(0, example - 1)));
    return text + fmt::format(".SH EXAMPLE\n.nf\n{}\n.fi\n", roff(footer.substr(example + title.size())));
}

std::string man_page(const Place& place, const std::vector<Place>& places) {
    const bool whole = place.words.empty();
    std::string text =
        fmt::format(".TH {} 1 \"\" \"porepack {}\" \"PorePack\"\n.SH NAME\n{} \\- {}\n", roff(page_name(place.words)), program_version(),
                    roff(page_name(place.words)),
                    whole ? "porosity, tortuosity and permeability of packings of grains" : roff(place.app->get_description()));
    text += synopsis_of(place);
    if (whole)
        text += ".SH DESCRIPTION\n" + roff(place.app->get_description()) +
                " A case is a folder with a file case.toml; values are in SI units.\n";
    if (!below(*place.app).empty()) {
        text += ".SH COMMANDS\n";
        for (const CLI::App* each : below(*place.app)) {
            const std::string page = page_name(whole ? each->get_name() : place.words + " " + each->get_name());
            text += fmt::format(".TP\n\\fB{}\\fR\n{}: \\fB{}\\fR(1)\n", roff(each->get_name()), roff(each->get_description()), roff(page));
        }
    }
    text += options_of(*place.app);
    if (whole)
        text +=
            ".SH ENVIRONMENT\n.TP\n\\fBOMP_NUM_THREADS\\fR\nthreads of parallel loops, if \\fB\\-\\-threads\\fR is not given\n"
            ".TP\n\\fBPOREPACK_HOME\\fR\nfolder with liggghts_templates, openfoam_cases, templates and cases, if these are not beside the "
            "program\n";
    text += footer_of(*place.app);
    std::vector<std::string> others;
    for (const Place& other : places) {
        const bool above = place.words.starts_with(other.words + " ") || (other.words.empty() && !whole);
        if (above) others.push_back(fmt::format("\\fB{}\\fR(1)", roff(page_name(other.words))));
    }
    if (!others.empty()) text += fmt::format(".SH SEE ALSO\n{}\n", fmt::join(others, ", "));
    return text;
}

// The values of a flag that has a list of them: "one of a, b".
std::string choices_of(const CLI::Option& option) {
    const std::string type = option.get_type_name(), start = "one of ";
    if (!type.starts_with(start)) return {};
    std::string words = type.substr(start.size());
    std::erase(words, ',');
    return words;
}

std::string bash_completion(const std::vector<Place>& places) {
    std::string calls, values, cases;
    for (const Place& place : places) {
        if (!place.words.empty()) calls += fmt::format("{}'{}'", calls.empty() ? "" : " | ", place.words);
        std::vector<std::string> commands, flags;
        for (const CLI::App* each : below(*place.app)) commands.push_back(each->get_name());
        for (const CLI::Option* option : shown_options(*place.app)) {
            const std::string choices = choices_of(*option);
            for (const std::string& name : option->get_lnames()) {
                flags.push_back("--" + name);
                if (!choices.empty()) values += fmt::format("        '{} --{}') words='{}' ;;\n", place.words, name, choices);
            }
        }
        cases += fmt::format("            '{}') words='{}' flags='{}' ;;\n", place.words, fmt::join(commands, " "), fmt::join(flags, " "));
    }
    // Where neither commands nor values are known, bash completes files.
    return fmt::format(R"(# Completion of porepack for bash.
_porepack() {{
    local current="${{COMP_WORDS[COMP_CWORD]}}" previous="${{COMP_WORDS[COMP_CWORD-1]}}" command="" words="" flags="" word
    for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
        case "${{command:+$command }}$word" in
            {}) command="${{command:+$command }}$word" ;;
        esac
    done
    case "$command $previous" in
{}        *)
            case "$command" in
{}            esac
            ;;
    esac
    [[ "$current" != -* ]] || words="$flags"
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}}
complete -o default -F _porepack porepack
)",
                       calls, values, cases);
}

}  // namespace

std::vector<Path> CommandLine::write_manual(const Path& folder) const {
    std::vector<Place> places;
    collect(*app_, "", places);
    std::vector<Path> written;
    const auto write = [&](const Path& name, const std::string& text) {
        core::make_folder((folder / name).parent_path());
        core::write_text(folder / name, text);
        written.push_back(folder / name);
    };
    for (const Place& place : places) write(Path("man") / "man1" / (page_name(place.words) + ".1"), man_page(place, places));
    write("man/man1/porepack_benchmark.1", ".so man1/porepack-benchmark.1\n");  // the program that `porepack benchmark` starts
    write(Path("bash-completion") / "completions" / "porepack", bash_completion(places));
    return written;
}

}  // namespace porepack::apps
