// Additions to CLI11: checks with clear messages, and one-line errors for a wrong command line.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

namespace skybody {

/// Accepts whole numbers in min..max, in decimal digits.
CLI::Validator whole_number(std::uint64_t min, std::uint64_t max);

/// Accepts finite numbers in min..max. (CLI::Range accepts NaN, and its message omits the allowed
/// range.) @param unit  for messages
CLI::Validator number_within(double min, double max, const std::string& unit = "");

/// Accepts one of `words`. @param noun  their kind, such as "policy"
/// @param others  words for messages: another part of the command line takes them
CLI::Validator one_of(const std::string& noun, const std::vector<std::string>& words,
                      const std::vector<std::string>& others = {});

/// One line about an invalid command line, with the remedy.
std::string describe_usage_error(const CLI::App& app, const CLI::ParseError& error);

/// "" if the first argument is a command or an option, otherwise an error message.
std::string check_command_name(const CLI::App& app, int count, const char* const* arguments);

}  // namespace skybody
