/// `maille report`: one self-contained page with the contents of the folder.

#include "report/page_parts.hpp"
#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

#include <regex>

namespace maille::studies {
namespace {

using test::maille_command;
using test::Outcome;
using test::TemporaryFolder;

// Truth: RFC 4648, section 10.
TEST(DataUriReference, AsTheStandardHasIt) {
  EXPECT_EQ(data_uri("text/plain", ""), "data:text/plain;base64,");
  EXPECT_EQ(data_uri("text/plain", "f"), "data:text/plain;base64,Zg==");
  EXPECT_EQ(data_uri("text/plain", "fo"), "data:text/plain;base64,Zm8=");
  EXPECT_EQ(data_uri("text/plain", "foo"), "data:text/plain;base64,Zm9v");
  EXPECT_EQ(data_uri("text/plain", "foob"), "data:text/plain;base64,Zm9vYg==");
  EXPECT_EQ(data_uri("text/plain", "fooba"), "data:text/plain;base64,Zm9vYmE=");
  EXPECT_EQ(data_uri("text/plain", "foobar"), "data:text/plain;base64,Zm9vYmFy");
}

/// A box with a title that is not to be taken for HTML, compared, and a page made of it.
struct ComparedFolder {
  ComparedFolder() {
    folder.write("box.toml",
                 "title = \"<b>pull</b> & \\\"turn\\\"\"\n" +
                     test::pulled_box_text("[8, 8, 8]", "[\"0.4 mm\", 0, \"0.2 mm\"]") +
                     test::measure_text("pull", "force = \"move[1]\"") +
                     test::measure_text("stretch", "strain = { mean = \"body\" }") +
                     test::measure_text("line", "displacement = { along = [[0, \"4 mm\", \"4 mm\"], "
                                                "[\"8 mm\", \"4 mm\", \"4 mm\"]], points = 5 }"));
    out = (folder / "out").string();
    compared = maille_command(fmt::format("compare {} --methods limits,coupled,fem_q1 --estimate --out {}",
                                          (folder / "box.toml").string(), out));
    reported = maille_command("report " + out);
    page = test::text_of(folder / "out/report.html");
  }
  TemporaryFolder folder;
  std::string out, page;
  Outcome compared, reported;
};

const ComparedFolder& compared_folder() {
  static const ComparedFolder one;
  return one;
}

std::vector<std::string> attributes(const std::string& page, const std::string& name) {
  const std::regex pattern("[ \n]" + name + "=\"([^\"]{0,40})");
  std::vector<std::string> values;
  for (std::sregex_iterator at(page.begin(), page.end(), pattern), end; at != end; ++at)
    values.push_back((*at)[1]);
  return values;
}

TEST(ReportContract, ThePageLoadsNothing) {
  const std::string& page = compared_folder().page;
  ASSERT_EQ(compared_folder().reported.code, 0) << compared_folder().reported.err;
  for (const char* name : {"src", "srcset"})
    for (const std::string& value : attributes(page, name))
      EXPECT_TRUE(value.starts_with("data:")) << name << ' ' << value;
  for (const std::string& value : attributes(page, "href"))
    EXPECT_TRUE(value.starts_with("#") || value == "data:," ||
                std::filesystem::exists(compared_folder().folder / ("out/" + value)))
        << value << ": a link to a file beside the page, and nothing else";
  EXPECT_FALSE(test::has(page, "@import"));
  EXPECT_FALSE(test::has(page, "url("));
  EXPECT_FALSE(test::has(page, "<link rel=\"stylesheet"));
}

TEST(ReportContract, TextsAreEscaped) {
  const std::string& page = compared_folder().page;
  EXPECT_FALSE(test::has(page, "<b>pull"));
  EXPECT_TRUE(test::has(page, "&lt;b&gt;pull"));
  EXPECT_TRUE(test::has(page, "&amp; "));
}

/// The rows of a table: the texts and keys of each cell.
struct ShownCell {
  std::string text, key;
};
std::vector<std::vector<ShownCell>> rows_of(const std::string& page, const std::string& id) {
  const auto table = page.find("<table id=\"" + id + "\""), from = page.find("<tbody>", table);
  std::vector<std::vector<ShownCell>> rows;
  if (table == std::string::npos || from == std::string::npos)
    return rows;
  const std::string body = page.substr(from, page.find("</tbody>", from) - from);
  const std::regex row_pattern("<tr[^>]*>(.*)</tr>"),
      cell_pattern("<td[^>]*?(?: data-key=\"([^\"]*)\")?>([^<]*)</td>");
  for (std::sregex_iterator row(body.begin(), body.end(), row_pattern), end; row != end; ++row) {
    rows.emplace_back();
    const std::string cells = (*row)[1];
    for (std::sregex_iterator cell(cells.begin(), cells.end(), cell_pattern); cell != end; ++cell)
      rows.back().push_back({(*cell)[2], (*cell)[1]});
  }
  return rows;
}

nlohmann::json results_of(const std::filesystem::path& file) {
  return nlohmann::json::parse(test::text_of(file));
}

/// A number as cells carry it to be sorted by.
std::string key_of(double value) {
  return fmt::format("{:.9g}", value);
}

TEST(ReportContract, ItOpensWithTheQuestion) {
  const std::string& page = compared_folder().page;
  const auto question =
      page.find("A box of 8 × 8 × 8 mm, held at x-, x+ moved by (0.4, 0, 0.2) mm: what force "
                "does it take, and where do strain and stress go?");
  ASSERT_NE(question, std::string::npos);
  // Truth: docs/report.md has this order.
  std::size_t last = question;
  for (const char* part : {"The body at rest", "Strain in a layer", "id=\"id-box-compare-parts\"",
                           "id=\"id-box-compare-forces\"", "The answers beside each other",
                           "id=\"id-box-compare-table\"", "Method by method"}) {
    const auto at = page.find(part, question);
    ASSERT_NE(at, std::string::npos) << part << compared_folder().reported.err;
    EXPECT_GT(at, last) << part;
    last = at;
  }
}

TEST(ReportContract, TablesOfPartsAndForcesAreThoseOfTheJson) {
  const nlohmann::json results = results_of(compared_folder().folder / "out/box_compare_results.json");
  const auto parts = rows_of(compared_folder().page, "id-box-compare-parts"),
             forces = rows_of(compared_folder().page, "id-box-compare-forces");
  ASSERT_EQ(parts.size(), 3u) << "one material, three methods";
  int n_forces = 0;
  for (const nlohmann::json& row : results["results"][0]["results"]) {
    const std::string method = row["method"];
    const nlohmann::json& mechanics = row["mechanics"];
    const auto part = std::ranges::find_if(parts, [&](const auto& cells) { return cells[1].text == method; });
    ASSERT_NE(part, parts.end()) << method;
    const nlohmann::json& body = mechanics["body"];
    EXPECT_EQ((*part)[2].key, key_of(body["volume"]));
    EXPECT_EQ((*part)[4].key, key_of(body["largest_strain"]["mean"]));
    if (body.contains("strain_energy")) {
      EXPECT_EQ((*part)[(*part).size() - 4].key, key_of(body["strain_energy"]));
    }
    // Truth: docs/report.md: the mean against that of the reference.
    const nlohmann::json& reference = results["results"][0]["results"].back()["mechanics"]["body"];
    const auto off = [](double value, double truth) { return key_of(std::abs(value / truth - 1)); };
    if (method == "coupled") {
      EXPECT_EQ((*part)[(*part).size() - 3].key,
                off(body["largest_strain"]["mean"], reference["largest_strain"]["mean"]));
      EXPECT_EQ(part->back().key, off(body["strain_energy"], reference["strain_energy"]));
    }
    if (method == "fem_q1") {
      EXPECT_EQ(part->back().text, "–") << "the reference itself";
    }
    for (const char* list : {"holds", "moves"})
      for (const nlohmann::json& one : mechanics[list]) {
        const auto force = std::ranges::find_if(forces, [&](const auto& cells) {
          return cells[0].text == one["name"].get<std::string>() && cells[2].text == method;
        });
        ASSERT_NE(force, forces.end()) << method << ' ' << one["name"];
        EXPECT_EQ((*force)[1].text, one["where"].get<std::string>());
        for (std::size_t axis = 0; axis < 3; ++axis) {
          EXPECT_EQ((*force)[3 + axis].key, key_of(one["force"][axis]));
          EXPECT_EQ((*force)[6 + axis].key, key_of(one["moment"][axis]));
        }
        ++n_forces;
      }
  }
  EXPECT_EQ(forces.size(), static_cast<std::size_t>(n_forces));
  EXPECT_GE(n_forces, 4) << "coupled and fem_q1 know forces";
}

TEST(ReportContract, TheTableOfMeasuresIsThatOfTheJson) {
  const nlohmann::json results = results_of(compared_folder().folder / "out/box_compare_results.json");
  const auto shown = rows_of(compared_folder().page, "id-box-compare-measures");
  ASSERT_EQ(shown.size(), 9u) << "three measures by three methods";
  int with_error = 0;
  for (const nlohmann::json& row : results["results"][0]["results"])
    for (const nlohmann::json& measure : row["measures"]) {
      const std::string name = measure["name"];
      const auto found = std::ranges::find_if(shown, [&](const auto& cells) {
        return cells[0].text == name && cells[1].text == row["method"].get<std::string>();
      });
      ASSERT_NE(found, shown.end()) << name;
      if (measure.contains("value") && measure["value"].is_number()) {
        EXPECT_EQ((*found)[2].key, key_of(measure["value"]));
      }
      if (row.contains("error") && row["error"]["measures"].contains(name) &&
          row["error"]["measures"][name].is_number()) {
        EXPECT_EQ((*found)[3].key, key_of(row["error"]["measures"][name]));
        ++with_error;
      }
    }
  EXPECT_GE(with_error, 4) << "coupled has three, limits the two that need no force";
  EXPECT_NE(std::ranges::find_if(shown,
                                 [](const auto& cells) {
                                   return cells[0].text == "pull" && cells[1].text == "limits" &&
                                          cells[2].text == "limits knows no forces";
                                 }),
            shown.end());
}

// Files of older versions have no mechanics, their scene may be gone: what there is is shown.
TEST(ReportContract, FoldersWithoutMechanicsOrSceneStillHaveTheirPage) {
  const TemporaryFolder folder;
  nlohmann::json results = results_of(compared_folder().folder / "out/box_compare_results.json");
  for (nlohmann::json& row : results["results"][0]["results"])
    row.erase("mechanics");
  results["title"] = "</script><script>alert(1)</script>";
  results["scene_text"] = "title = \"</title><script>\"";
  folder.write("box_compare_results.json", results.dump());
  const Outcome run = test::done("report " + folder.path().string());
  const std::string page = test::text_of(folder / "report.html");
  EXPECT_EQ(rows_of(page, "id-box-compare-table").size(), 3u);
  EXPECT_TRUE(rows_of(page, "id-box-compare-parts").empty());
  EXPECT_EQ(page.find("<script>"), page.rfind("<script>")) << "the page's own, which sorts tables";
  EXPECT_TRUE(test::has(page, "&lt;script&gt;alert"));
  EXPECT_TRUE(test::has(page, "no pictures of box"));
}

TEST(ReportContract, PlaysAndProbesHaveTheirSections) {
  const TemporaryFolder folder;
  folder.write(
      "ring_play_results.json",
      R"({"kind":"play","scene":"ring","title":"a <ring>","method":"limits","moments":3,)"
      R"("command":"maille play ring.toml pull.csv","scene_file":"/a/ring.toml","scene_text":"[[object]]"})");
  folder.write(
      "frames.json",
      R"({"scene":"ring","trajectory":"pull","method":"limits","frames_asked":2,"frame_seconds":0.5,"objects":[],)"
      R"("frames":[{"frame":1,"drives":[],"contacts":[{"object":"ring","other":"wall","voxels":2,"force":[3,4,0]}]},)"
      R"({"frame":2,"drives":[],"contacts":[{"object":"ring","other":"wall","voxels":2,"force":[0,0,1]}]}]})");
  folder.write(
      "finger.json",
      R"({"title":"a finger & a belly","ticks":1000,"period_s":0.001,"in_real_time":false,"tool_voxels":57,)"
      R"("deformable_bodies":1,"force":{"largest_n":2.5,"mean_touching_n":1,"largest_torque_nm":0.01,)"
      R"("touching_ticks":400},"bodies":{"deepest_m":0.002},"passivity":{"stiffness":300},"penetrations":0})");
  for (const char* name : {"ring_0000.png", "ring_0001.png", "ring_0002.png", "finger.png"})
    folder.write(name, "\x89PNG");
  const Outcome run = test::done("report " + folder.path().string());
  const std::string page = test::text_of(folder / "report.html");
  for (const char* text : {"Play: a &lt;ring&gt;", "by limits, driven by pull; 2 of 2 frames",
                           "ring_0002.png", "maille play ring.toml pull.csv", "Probe: a finger &amp; a belly",
                           "2.5 N", "2 mm", "<a href=\"finger.json\">"})
    EXPECT_TRUE(test::has(page, text)) << text;
  EXPECT_FALSE(test::has(page, "Other pictures")) << "every picture belongs to a section";
  const auto touches = rows_of(page, "id-ring-play-table");
  ASSERT_EQ(touches.size(), 1u);
  EXPECT_EQ(touches[0][0].text, "ring against wall");
  EXPECT_EQ(touches[0][1].text, "2");
  EXPECT_EQ(touches[0][2].text, "5 N");
}

TEST(ReportContract, HasEverySection) {
  const std::string& page = compared_folder().page;
  for (const char* part :
       {"<html lang=\"en\">", "<h1>", "id=\"id-box-compare\"", "id=\"id-box-compare-table\"",
        "Method by method", "<h3>The scene</h3>", "youngs_modulus", "maille check --why",
        "<h3>The command</h3>", "maille compare", "--methods", "estimated L2", "<h2>Files</h2>",
        "box_limits.vti", "box_compare_results.json"})
    EXPECT_TRUE(test::has(page, part)) << part;
  EXPECT_EQ(attributes(page, "alt").size(), attributes(page, "src").size()) << "every picture has a text";
  for (const std::string& text : attributes(page, "alt"))
    EXPECT_FALSE(text.empty());
}

TEST(ReportContract, CompareEstimatesWhereItIsAskedTo) {
  const Outcome& compared = compared_folder().compared;
  ASSERT_EQ(compared.code, 0) << compared.err;
  EXPECT_TRUE(test::has(compared.out, "estimated"));
  EXPECT_TRUE(test::has(compared.out, "multigrid cycles"));
  EXPECT_TRUE(test::has(compared.out, "of finite elements there is none"));
  const std::string vti = test::text_of(compared_folder().folder / "out/box_limits.vti");
  EXPECT_TRUE(test::has(vti, "DisplacementErrorEstimate"));
}

TEST(ReportContract, AFolderWithoutResultsIsAFaultyInput) {
  const TemporaryFolder folder;
  test::refused("report " + folder.path().string());
  test::refused("report " + (folder / "none").string());
}

/// Two cases of a study by two methods, the second torn as a killed study leaves it.
const char* const study_lines =
    R"({"study":"ratio","case":1,"cases":2,"scene":"bar","parameters":{"material.E_fibre":1000.0,"limits.from":"taut"},"method":"limits","status":"done","message":"","error":{"relative_l2":0.25,"relative_max":0.5,"rms":1e-4},"seconds":{"setup":0.001,"solve":0.002,"total":0.003},"bytes":2048,"iterations":7,"reference":"fem_q2"}
{"study":"ratio","case":2,"cases":2,"scene":"bar","parameters":{"material.E_fibre":50000.0,"limits.from":"taut"},"method":"limits","status":"done","message":"","error":{"relative_l2":0.125,"relative_max":null,"rms":1e-4},"seconds":{"setup":0.001,"solve":1.5,"total":1.501},"bytes":2048,"iterations":7,"reference":"fem_q2"}
{"study":"ratio","case":2,"ca)";

TEST(ReportGolden, TheTableOfAStudy) {
  const TemporaryFolder folder;
  folder.write("ratio.jsonl", study_lines);
  const Outcome run =
      test::done("report " + folder.path().string() + " --out " + (folder / "r.html").string());
  const std::string page = test::text_of(folder / "r.html");
  const auto from = page.find("<tbody>"), to = page.find("</tbody>");
  ASSERT_NE(to, std::string::npos);
  // Truth: unchanged since it was looked at.
  const auto number = [](const std::string& key, const char* text) {
    return "<td class=\"number\"" + (key.empty() ? "" : " data-key=\"" + key + "\"") + ">" + text + "</td>";
  };
  const std::string words = "<td>taut</td><td>limits</td><td>done</td>",
                    end = number("2048", "2 KiB") + number("7", "7") + "<td></td></tr>\n";
  EXPECT_EQ(page.substr(from, to - from), "<tbody>\n<tr>" + number("1", "1") + number("1000", "1000") +
                                              words + number("0.25", "25 %") + number("0.5", "50 %") +
                                              number("0.003", "3 ms") + end + "<tr>" + number("2", "2") +
                                              number("50000", "50000") + words + number("0.125", "12.5 %") +
                                              number("", "–") + number("1.501", "1.5 s") + end);
  EXPECT_TRUE(test::has(page, "2 of 2 cases, 2 rows, 0 of them not settled"));
}

// One broken file costs its own section, and is named; rows that were put aside are no study; pictures are
// pictures.
TEST(ReportContract, FilesThatAreNotWhatTheySeemAreNamedAndLeftOut) {
  const TemporaryFolder folder;
  const std::string lines = std::string(study_lines).substr(0, std::string(study_lines).rfind('\n') + 1);
  folder.write("ratio.jsonl", lines);
  folder.write("ratio_older.jsonl", lines);
  folder.write(
      "ratio_about.json",
      R"({"kind":"study","study":"ratio","title":"stiff & soft","command":"maille study r.toml",)"
      R"("scene_file":"/a/r.toml","scene_text":"scene = 1","explanation":"it costs","sensitivity":[)"
      R"({"scene":"bar","method":"coupled","label":"force [N]","undetermined":"","parameters":[)"
      R"({"parameter":"E","first":0.25,"first_low":0.2,"first_high":0.3,"total":0.5,"total_low":0.5,"total_high":0.5}]},)"
      R"({"scene":"bar","method":"relaxed","label":"force [N]","undetermined":"too few","parameters":[]}]})");
  folder.write("broken.json", "{\"kind\":");
  folder.write("odd.json", R"({"kind":"run","results":"none","files":[1,2],"title":3})");
  folder.write("secret.png", "root:x:0:0");
  folder.write("huge.png", "\x89PNG" + std::string(17 << 20, ' '));
  const Outcome run =
      test::done("report " + folder.path().string() + " --out " + (folder / "r.html").string());
  for (const char* name : {"broken.json", "secret.png", "huge.png"})
    EXPECT_TRUE(test::has(run.err, name)) << name;
  const std::string page = test::text_of(folder / "r.html");
  for (const char* text : {"Study: stiff &amp; soft", "scene = 1", "it costs", "maille study r.toml",
                           "ratio_older.jsonl", "How do the answers depend on material.E_fibre?",
                           "0.250 (0.20 to 0.30)", ">0.500<", "bar, relaxed: undetermined: too few"})
    EXPECT_TRUE(test::has(page, text)) << text;
  EXPECT_FALSE(test::has(page, "cm9vdDp4OjA6MA")) << "the text of the false picture";
  EXPECT_EQ(page.find("2 of 2 cases"), page.rfind("2 of 2 cases")) << "one study";
  EXPECT_LT(page.size(), std::size_t{1} << 20);
}

/// What Debian's browser makes of a page, without a screen.
std::optional<Outcome> browse(const std::string& options, const std::string& address) {
  if (test::shell("command -v chromium").code != 0)
    return std::nullopt;
  const TemporaryFolder profile;
  return test::shell(fmt::format(
      "timeout 60 chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage "
      "--user-data-dir={} --enable-logging=stderr --host-resolver-rules='MAP * ~NOTFOUND' {} '{}'",
      profile.path().string(), options, address));
}

TEST(ReportContract, ABrowserShowsItWithoutComplaintAndSortsItsTable) {
  ASSERT_EQ(compared_folder().reported.code, 0);
  const std::string address = "file://" + compared_folder().out + "/report.html?sort=id-box-compare-table.";
  const auto rising = browse("--dump-dom", address + "8"), falling = browse("--dump-dom", address + "-8");
  if (!rising || !falling)
    GTEST_SKIP() << "there is no chromium here (apt-get install chromium)";
  ASSERT_EQ(rising->code, 0) << rising->err;
  for (const Outcome* dom : {&*rising, &*falling})
    EXPECT_FALSE(test::has(dom->err, "CONSOLE")); // the page's policy forbids any request
  const auto order = [](const std::string& page) {
    const auto table = page.find("id=\"id-box-compare-table\""), from = page.find("<tbody>", table);
    const std::string body = page.substr(from, page.find("</tbody>", from) - from);
    std::vector<std::pair<std::size_t, std::string>> places;
    for (const char* method : {"limits", "coupled", "fem_q1"})
      places.emplace_back(body.find(fmt::format("<td>{}</td>", method)), method);
    std::ranges::sort(places);
    return places[0].second + " " + places[1].second + " " + places[2].second;
  };
  EXPECT_EQ(order(rising->out), "coupled limits fem_q1") << "the reference has no error: last";
  EXPECT_EQ(order(falling->out), "limits coupled fem_q1") << "last either way";
  EXPECT_TRUE(test::has(rising->out, "aria-sort=\"ascending\""));
  EXPECT_TRUE(test::has(falling->out, "aria-sort=\"descending\""));
  EXPECT_TRUE(test::has(rising->out, "<button type=\"button\">"));
}

} // namespace
} // namespace maille::studies
