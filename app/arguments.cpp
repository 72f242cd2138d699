#include "app/arguments.h"

#include <algorithm>
#include <charconv>

#include "core/io/files/text.h"
#include "core/io/files/unit_hint.h"

namespace skybody {
namespace {

bool parse_whole(const std::string& text, std::uint64_t& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

/// The innermost selected command, or the program itself.
const CLI::App& innermost(const CLI::App& app) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  return given.empty() ? app : innermost(*given.front());
}

std::string path_of(const CLI::App& app) {
  return app.get_parent() == nullptr ? app.get_name()
                                     : path_of(*app.get_parent()) + " " + app.get_name();
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

std::string describe_extra(const CLI::App& command, const std::string& argument) {
  if (argument.empty() || argument[0] != '-') return "unexpected argument `" + argument + "`";
  const std::string name = argument.substr(0, argument.find('='));
  const std::string near = closest(name, option_names(command));
  return "unknown option `" + name + "`" + (near.empty() ? "" : "; did you mean `" + near + "`?");
}

/// The argument to report as unexpected: an option rather than its possible value, otherwise the
/// first one. CLI11 lists them in its message only: "... not expected: LAST ... FIRST".
std::string first_extra(const CLI::ParseError& error) {
  const std::string text = error.what();
  const std::vector<std::string> extras = split_words(text.substr(text.find(": ") + 1));
  for (const std::string& extra : extras) {
    if (extra.size() > 1 && extra[0] == '-') return extra;
  }
  return extras.empty() ? "" : extras.back();
}

/// CLI11's own text: "--seed: PROBLEM", "SCENARIO is required".
std::string describe_other(const CLI::ParseError& error) {
  std::string text = error.what();
  std::replace(text.begin(), text.end(), '\n', ' ');
  if (error.get_name() == "RequiredError") {
    const std::size_t end = text.find(" is required");
    if (end != std::string::npos) return text.substr(0, end) + " is missing";
  }
  if (error.get_name() == "ArgumentMismatch") {
    const bool too_many = text.find("At Most") != std::string::npos;
    return text.substr(0, text.find(':')) +
           (too_many ? " is given more than once" : " is given without its value");
  }
  return text;
}

}  // namespace

CLI::Validator whole_number(std::uint64_t min, std::uint64_t max) {
  const std::string range = std::to_string(min) + ".." + std::to_string(max);
  const auto check = [min, max, range](const std::string& text) -> std::string {
    std::uint64_t value = 0;
    if (!parse_whole(text, value)) return "`" + text + "` is not a whole number; allowed: " + range;
    if (value < min || value > max) return text + " is out of range; allowed: " + range;
    return "";
  };
  return {check, "", "whole number"};
}

CLI::Validator number_within(double min, double max, const std::string& unit) {
  const std::string range =
      format_number(min) + ".." + format_number(max) + (unit.empty() ? "" : " ") + unit;
  const auto check = [min, max, range, unit](const std::string& text) -> std::string {
    const std::optional<double> value = parse_number(text);
    if (!value) {
      return "`" + text + "` is not a number; allowed: " + range + unit_hint(text, unit);
    }
    if (*value >= min && *value <= max) return "";  // false for NaN
    return text + " is out of range; allowed: " + range;
  };
  return {check, "", "number"};
}

CLI::Validator one_of(const std::string& noun, const std::vector<std::string>& words,
                      const std::vector<std::string>& others) {
  std::vector<std::string> all = words;
  all.insert(all.end(), others.begin(), others.end());
  const auto check = [noun, words, all](const std::string& text) -> std::string {
    if (std::find(words.begin(), words.end(), text) != words.end()) return "";
    const std::string near = closest(text, all);
    return "there is no " + noun + " `" + text + "`" +
           (near.empty() ? "" : "; did you mean `" + near + "`?") + "; allowed: " + join(all);
  };
  return {check, "", noun};
}

std::string describe_usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = innermost(app);
  const bool is_extras = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError);
  const std::string extra = is_extras ? first_extra(error) : "";
  const std::string text = extra.empty() ? describe_other(error) : describe_extra(command, extra);
  return text + "; see `" + path_of(command) + " --help`";
}

std::string check_command_name(const CLI::App& app, int count, const char* const* arguments) {
  const std::vector<std::string> names = command_names(app);
  const std::string help = "; see `skybody --help`";
  if (count < 2) return "no command is given; there are " + join(names) + help;
  const std::string given = arguments[1];
  if (given.empty() || given[0] == '-') return "";
  if (std::find(names.begin(), names.end(), given) != names.end()) return "";
  const std::string near = closest(given, names);
  return "unknown command `" + given + "`" +
         (near.empty() ? "; there are " + join(names) : "; did you mean `" + near + "`?") + help;
}

}  // namespace skybody
