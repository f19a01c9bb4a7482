// make_folder DIR RECORDS PICTURED SIDE: the folder that the browser test makes a report of; the first PICTURED records
// have images.
#include "tests/support/report_fixture.h"

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  opaline::test::write_report_folder(argv[1], {std::stoul(argv[2]), std::stoul(argv[3]), true, std::stoi(argv[4])});
}
