#include "judge/page_of.hpp"

#include "judge/page_figures.hpp"
#include "judge/page_tables_of.hpp"
#include "judge/shapes.hpp"

namespace stillframe::judge {

page::PageData page_of(const RunAnalyses& runs, const report::Verdict& verdict) {
  page::PageData page;
  page.head = head_of(runs, verdict);
  page.warnings = warnings_of(runs, verdict);
  page.result = results_of(verdict);
  page.singular_values = singular_value_figure(runs);
  page.transmissibility = transmissibility_figures(runs, verdict);
  page.histories = histories_of(runs);
  page.leg_forces = leg_forces_of(runs);
  page.spectra = spectra_of(runs);
  page.histograms = histograms_of(runs);
  add_tables(verdict, page);
  add_log_tables(runs, page);
  const auto& design = runs.any().run.design;
  if (design) {
    page.gains = gain_tables(design->gains);
    try {
      // Of the whole frame, which is what the plant runs.
      page.modes = mode_shapes(design->scene, make_model(design->scene));
    } catch (const std::exception& error) {
      page.warnings.push_back(
          {page::Severity::note, std::string("Mode shapes cannot be drawn: ") + error.what()});
    }
  }
  const auto& info = runs.any().data.scan.info;
  page.texts = {{"Scene", info.scene_text}, {"Floor", info.floor_text}};
  return page;
}

}  // namespace stillframe::judge
