% The signals of a log in MATLAB or Octave, in the folder of run.mat and run.csv:
%   stillframe export LOG --mat run.mat --csv run.csv
run = load('run.mat');
[~, lens_z] = ismember('lens_z', run.frame_acceleration_names);
printf('rms of lens_z: %.6g %s\n', sqrt(mean(run.frame_acceleration(:, lens_z) .^ 2)), ...
       run.frame_acceleration_unit);

table = dlmread('run.csv', ',', 1, 0);  % a row a sample: seq, time_s, then the signals
printf('%d samples in the text, %d in the .mat file\n', size(table, 1), numel(run.time_s));
