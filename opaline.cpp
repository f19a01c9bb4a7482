// The command line: the list of subcommands, and one exit code for each kind of error.
#include "datasets_synthetic/cmd/commands.h"
#include "datasets_synthetic/shapes/shapes.h"
#include "fit/cmd/commands.h"
#include "model/cmd/commands.h"
#include "render/choices.h"
#include "render/cmd/commands.h"
#include "render/cmd/exit_status.h"
#include "render/input_error.h"
#include "render/render_scene.h"
#include "reports/cmd/commands.h"
#include "validate/cmd/commands.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <new>

namespace opaline {
namespace {

void add_commands(CLI::App& app) {
  const ShapeLibrary& shapes = synthetic_shapes();
  app.set_version_flag("--version", "opaline " + version());
  app.footer(
      "`opaline COMMAND --help` explains a command. Exit codes: 0 done; 1 a comparison or gate failed;\n"
      "2 the input or the arguments are wrong; 3 the machine lacks something.");
  add_profile_command(app);
  add_material_command(app);
  add_stress_command(app);
  add_transport_command(app);
  add_dataset_command(app, shapes);
  add_render_command(app, shapes, choose_from_records);
  add_fit_command(app, shapes);
  add_compare_command(app);
  add_validate_command(app, shapes);
  add_report_command(app);
  add_depth_texture_command(app);
}

/// CLI11 would call a misspelt command an unexpected argument.
void check_command(const CLI::App& app, const std::string& name) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  if (name.rfind('-', 0) != 0 && std::find(names.begin(), names.end(), name) == names.end())
    throw std::invalid_argument(unknown_choice("command", name, names));
}

void parse_and_run(CLI::App& app, int argc, char** argv) {
  if (argc > 1) check_command(app, argv[1]);
  app.parse(argc, argv);
  if (app.get_subcommands().empty()) std::fputs(app.help().c_str(), stdout);
  if (std::fflush(stdout) != 0) throw MachineError("standard output cannot be written");
}

int report(const char* what, ExitStatus status) {
  std::fflush(stdout);
  std::fprintf(stderr, "opaline: %s\n", what);
  return status;
}

int run(int argc, char** argv) {
  CLI::App app("Opaline: fits translucent materials to images, and measures rendering techniques for them.", "opaline");
  try {
    add_commands(app);
    parse_and_run(app, argc, argv);
    return exit_done;
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? app.exit(error) : report(error.what(), exit_wrong_input);
  } catch (const CommandFailed& error) {
    return report(error.what(), exit_failed);
  } catch (const InputError& error) {
    return report(error.what(), exit_wrong_input);
  } catch (const std::invalid_argument& error) {
    return report(error.what(), exit_wrong_input);
  } catch (const std::bad_alloc&) {
    return report("not enough memory", exit_machine);
  } catch (const std::exception& error) {
    return report(error.what(), exit_machine);
  }
}

}  // namespace
}  // namespace opaline

int main(int argc, char** argv) { return opaline::run(argc, argv); }
