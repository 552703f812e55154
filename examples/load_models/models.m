% The linear models of a loop in MATLAB or Octave, in the folder of loop.mat:
%   stillframe design SCENE --mat loop.mat
% Octave: pkg load control
load('loop.mat');  plant = ss(plant.A, plant.B, plant.C, plant.D);
closed_names = closed.input_names;
closed = ss(closed.A, closed.B, closed.C, closed.D, closed.Ts);

at_20_hz = sigma(closed(:, 1:6), 2 * pi * 20);
printf('largest singular value at 20 Hz, closed loop: %.4f\n', max(at_20_hz));
