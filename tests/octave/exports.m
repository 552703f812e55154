% exports.m EXAMPLES: runs the examples in a folder that holds loop.mat, run.mat, run.csv and design.json, compares what
% they loaded with what the program says of the same loop, and writes everything back for a comparison of the bits.
% Exit code 77 without the control package.
try
  pkg load control
catch
  exit(77);
end
examples = argv(){1};

source(fullfile(examples, 'models.m'));
said = jsondecode(fileread('design.json'));
assert(isct(plant) && isdt(closed));
assert(size(plant), [numel(said.legs) + 6, numel(said.legs) + 6]);
assert(numel(closed_names), columns(closed.b));
% The states are balanced and the values of order one; a sum of thirty terms rounds at 1e-14.
values = sigma(closed(:, 1:6), 2 * pi * said.frequencies_hz(:)');
assert(values', said.closed_singular_values, -1e-9);
assert(max(abs(eig(closed.a))), said.spectral_radius, -1e-9);

source(fullfile(examples, 'signals.m'));
wide = [run.seq, run.time_s, run.floor_acceleration, run.sigma, run.applied_force, run.frame_acceleration, ...
        run.command_force];
assert(isequaln(table, wide));  % equal numbers; -0 and 0 are told apart by the bits below

loop = load('loop.mat');
save('-v6', 'loop_back.mat', '-struct', 'loop');
save('-v6', 'run_back.mat', '-struct', 'run');
save('-v6', 'csv_back.mat', 'table');
