// The report: reads the data that stand in the page and draws every figure that has its place there.
import {histories} from './figures/histories.js';
import {histograms} from './figures/histograms.js';
import {modeShapes} from './figures/modes.js';
import {singularValues} from './figures/singular_values.js';
import {spectra} from './figures/spectra.js';
import {fit, transmissibility} from './figures/transmissibility.js';
import {schemeSwitch} from './theme.js';

const data = JSON.parse(document.getElementById('stillframe-data').textContent);

schemeSwitch(document.getElementById('scheme'));
if (data.singular_values) singularValues(data.singular_values);
if (data.transmissibility) transmissibility(data.transmissibility);
if (data.fit) fit(data.fit);
if (data.modes) modeShapes(data.modes);
if (data.histories) histories(data.histories);
if (data.spectra) spectra(data.spectra);
if (data.histograms) histograms(data.histograms);
