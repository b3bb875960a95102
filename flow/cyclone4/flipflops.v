// Flip-flops of dfflegalize become dffeas cells: clock enable, and below it a synchronous clear.

module \$_DFFE_PP_ (input D, C, E, output Q);
  parameter _TECHMAP_WIREINIT_Q_ = 1'bx;
  dffeas #(.power_up(_TECHMAP_WIREINIT_Q_ === 1'b1 ? "high" : "low")) _TECHMAP_REPLACE_ (
    .d(D), .q(Q), .clk(C), .ena(E), .sclr(1'b0),
    .clrn(1'b1), .prn(1'b1), .asdata(1'b0), .aload(1'b0), .sload(1'b0));
  wire _TECHMAP_REMOVEINIT_Q_ = 1;
endmodule

module \$_SDFFCE_PP0P_ (input D, C, R, E, output Q);
  parameter _TECHMAP_WIREINIT_Q_ = 1'bx;
  dffeas #(.power_up(_TECHMAP_WIREINIT_Q_ === 1'b1 ? "high" : "low")) _TECHMAP_REPLACE_ (
    .d(D), .q(Q), .clk(C), .ena(E), .sclr(R),
    .clrn(1'b1), .prn(1'b1), .asdata(1'b0), .aload(1'b0), .sload(1'b0));
  wire _TECHMAP_REMOVEINIT_Q_ = 1;
endmodule
