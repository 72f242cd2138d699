#include "app/report/report.h"

#include <cstdio>
#include <exception>
#include <new>

#include "app/report/output.h"
#include "core/base/system/printable.h"
#include "core/io/yaml/diagnostics.h"
#include "core/model/located_error.h"

namespace skybody {
namespace {

int report_diagnostics(const InputError& error) {
  std::string text;
  for (const Diagnostic& diagnostic : error.diagnostics()) {
    text += (text.empty() ? "" : "\n") + diagnostic.to_string();
  }
  return report_error(text);
}

}  // namespace

int report_error(const std::string& message) {
  std::fflush(stdout);
  std::fprintf(stderr, "%s\n", message.c_str());
  return kExitError;
}

int run_and_report(const Action& work) {
  try {
    const int status = work();
    flush_output();
    return status;
  } catch (const InputError& error) {
    return report_diagnostics(error);
  } catch (const LocatedError& error) {
    return report_error(Diagnostic{Severity::kError, error.mark(), error.message()}.to_string());
  } catch (const Error& error) {
    return report_error("error: " + printable(error.what()));
  } catch (const std::bad_alloc&) {
    return report_error("error: out of memory");
  } catch (const std::exception& error) {
    report_error(std::string("internal error: ") + error.what());
    return kExitBug;
  }
}

}  // namespace skybody
