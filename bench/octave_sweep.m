% The partner of bench/race_octave: times Octave's control package on the numbers that
% bench_frequency_sweep wrote. Called as octave-cli octave_sweep.m FOLDER; reads "go" or "end" from
% the pipe FOLDER/to_octave, opened for every line as fgetl reads ahead, and answers every "go" with
% microseconds of processor time a frequency: freqresp and svd in a loop, sigma, and a loop of
% backslash and svd without the package.
pkg load control
folder = argv(){1};
omega = load(fullfile(folder, "omega.txt"))';
n = numel(omega);
for plant = 1:2
  part = @(name) load(fullfile(folder, sprintf("%s_%d.txt", name, plant)));
  A{plant} = part("A"); B{plant} = part("B"); C{plant} = part("C"); D{plant} = part("D");
end

function [values, time] = by_freqresp(sys, omega)
  start = cputime;
  H = freqresp(sys, omega);
  values = zeros(min(size(H, 1), size(H, 2)), numel(omega));
  for k = 1:numel(omega)
    values(:, k) = svd(H(:, :, k));
  end
  time = cputime - start;
end

function [values, time] = by_sigma(sys, omega)
  start = cputime;
  values = sigma(sys, omega);
  time = cputime - start;
end

function [values, time] = by_backslash(A, B, C, D, omega)
  start = cputime;
  values = zeros(min(size(D)), numel(omega));
  I = eye(rows(A));
  for k = 1:numel(omega)
    values(:, k) = svd(C * ((1i * omega(k) * I - A) \ B) + D);
  end
  time = cputime - start;
end

function line = next_line(pipe)
  file = fopen(pipe);
  line = fgetl(file);
  fclose(file);
end

for plant = 1:2
  sys{plant} = ss(A{plant}, B{plant}, C{plant}, D{plant});
  by_freqresp(sys{plant}, omega);  % the first call loads and compiles; it does not count
  by_sigma(sys{plant}, omega);
  by_backslash(A{plant}, B{plant}, C{plant}, D{plant}, omega);
end
printf("ready\n");
fflush(stdout);
while strcmp(next_line(fullfile(folder, "to_octave")), "go")
  answer = "";
  for plant = 1:2
    [first{plant}, t_1] = by_freqresp(sys{plant}, omega);
    [second, t_2] = by_sigma(sys{plant}, omega);
    [third, t_3] = by_backslash(A{plant}, B{plant}, C{plant}, D{plant}, omega);
    answer = [answer, sprintf("%.3f %.3f %.3f ", 1e6 / n * [t_1, t_2, t_3])];
  end
  printf("%s\n", answer);
  fflush(stdout);
end
for plant = 1:2
  values = first{plant};
  dlmwrite(fullfile(folder, sprintf("octave_%d.txt", plant)), values, "delimiter", " ", ...
           "precision", "%.17g");
end
